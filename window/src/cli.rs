//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, exit};
use clap::Parser;

use crate::display::Wanted;
pub use crate::program::LabelReader;
use crate::program::Options;
use crate::run::run;

/// Shows a run on the screen: its images, the sight on the chosen target, and what they rest on.
#[derive(Debug, Parser)]
#[command(
    name = "window",
    version,
    after_help = "The pilot starts this process: pilot run SCENE --window\n\n\
    Examples (by hand, in a run that is going):\n  \
    window --run-dir /run/user/1000/trocar/default\n  \
    DISPLAY=:1 window --run-dir /run/user/1000/trocar/default --only sight\n\n\
    Keys: Space marks, Page up and Page down choose the target, F6 holds, F9 takes a picture, Esc shows all views;\n\
    a click on an image enlarges it. A pedal that sends keys does the same."
)]
struct Cli {
    /// The run's folder.
    #[arg(long)]
    run_dir: PathBuf,
    /// The pilot's process; this one ends with it.
    #[arg(long)]
    parent: Option<u32>,
    /// The sight alone, for a second display.
    #[arg(long, value_name = "PART", value_parser = ["sight"])]
    only: Option<String>,
    /// Columns and rows of the window [default: the whole screen]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Width of the monitor's picture, mm [default: as the display says]
    #[arg(long, value_name = "MM")]
    monitor_mm: Option<f32>,
    /// Where pictures of the screen go.
    #[arg(long, value_name = "DIR", default_value = ".")]
    shots: PathBuf,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides: Vec<u32> = text.split('x').filter_map(|side| side.parse().ok()).collect();
    match sides[..] {
        [width, height] if (64..=16_384).contains(&width) && (64..=16_384).contains(&height) => Ok([width, height]),
        _ => Err("expected columns x rows, each 64 to 16384, such as 1920x1080".to_owned()),
    }
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary.
pub fn main(load: LabelReader) -> ExitCode {
    let cli = Cli::parse();
    let membership = Membership {
        run_dir: cli.run_dir,
        parent: cli.parent,
    };
    let only_sight = cli.only.is_some();
    let options = Options {
        wanted: Wanted {
            size: cli.size,
            monitor_mm: cli.monitor_mm,
            title: "Trocar (research software, not a medical device)".to_owned(),
        },
        only_sight,
        shots: cli.shots,
        load,
        name: if only_sight { "sight" } else { "window" }.to_owned(),
    };
    exit("window", run(&membership, options))
}
