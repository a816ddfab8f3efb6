//! The command line.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, exit};
use clap::Parser;

use crate::chain::diagram;
use crate::run;

/// Follows the tool and publishes its pose in the patient.
#[derive(Debug, Parser)]
#[command(
    name = "tracker-proc",
    version,
    after_help = "Example (the pilot starts this process; by hand it joins a run that is going):\n  \
    tracker-proc --run-dir /tmp/trocar-0/default\n\n\
    The states as a picture: tracker-proc --diagram | dot -Tsvg > states.svg\n\n\
    The scene's [tracker] table says what is followed: see `pilot --help`."
)]
struct Cli {
    /// Prints what the tracker can say of the tool, and what leads from one to the other, as a graph in the DOT language.
    #[arg(long, exclusive = true)]
    diagram: bool,
    /// The run's folder.
    #[arg(long, required_unless_present = "diagram")]
    run_dir: Option<PathBuf>,
    /// The pilot's process; this one ends with it.
    #[arg(long)]
    parent: Option<u32>,
    /// When sample 0 is due, ns on the run's clock [default: as the run's pilot says, once this process is ready]
    #[arg(long, allow_hyphen_values = true)]
    start_ns: Option<i64>,
    /// In simulated time: goes on behind this moment, ns, for a tracker that died [default: from sample 0 on]
    #[arg(long, allow_hyphen_values = true)]
    after_ns: Option<i64>,
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    if cli.diagram {
        // A reader that has closed its end wants no more.
        let _ = std::io::stdout().write_all(diagram().as_bytes());
        return ExitCode::SUCCESS;
    }
    let membership = Membership {
        run_dir: cli.run_dir.unwrap_or_default(),
        parent: cli.parent,
    };
    exit("tracker-proc", run::run(&membership, cli.start_ns, cli.after_ns))
}
