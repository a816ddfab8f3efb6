//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use bus::process::{Membership, exit};
use clap::Parser;

use super::RunError;
use super::run::{NAME, Options, run};

/// Reads the window's picture back off the screen, and covers it in red when it must not be believed.
#[derive(Debug, Parser)]
#[command(
    name = "window-watch",
    version,
    after_help = "Examples (the pilot starts this process; by hand it joins a run that is going):\n  \
    DISPLAY=:0 window-watch --run-dir /run/user/1000/trocar/default\n  \
    window-watch --run-dir /tmp/trocar-0/default --limit-ms 500        # on a slow machine\n\n\
    It needs an X server, which the variable DISPLAY names. What it sees and what it cannot see: docs/window-watch.md."
)]
struct Cli {
    /// The run's folder.
    #[arg(long)]
    run_dir: PathBuf,
    /// The pilot's process; this one ends with it.
    #[arg(long)]
    parent: Option<u32>,
    /// A picture that is not followed by a newer one for longer is covered, ms.
    #[arg(long, value_name = "MS", default_value_t = 300, value_parser = clap::value_parser!(u64).range(150..=5000))]
    limit_ms: u64,
    /// Between two looks at the screen, ms.
    #[arg(long, value_name = "MS", default_value_t = 50, value_parser = clap::value_parser!(u64).range(5..=1000))]
    look_ms: u64,
    /// A window that gives no sign of life on the bus for longer is covered, ms.
    #[arg(long, value_name = "MS", default_value_t = 2000, value_parser = clap::value_parser!(u64).range(500..=60000))]
    silent_ms: u64,
    /// So many newer pictures lift the cover, each within the limit of the one before.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    good: u32,
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary.
pub fn main() -> ExitCode {
    main_with(Cli::parse())
}

/// The same with these arguments, the program's name first: for tests that have no binary of it.
pub fn main_from(arguments: &[&str]) -> ExitCode {
    main_with(Cli::parse_from(arguments))
}

fn main_with(cli: Cli) -> ExitCode {
    let options = Options {
        limit: Duration::from_millis(cli.limit_ms),
        look: Duration::from_millis(cli.look_ms),
        silent: Duration::from_millis(cli.silent_ms),
        good: cli.good,
    };
    let membership = Membership {
        run_dir: cli.run_dir,
        parent: cli.parent,
    };
    let display = std::env::var("DISPLAY").ok().filter(|display| !display.is_empty());
    let result = display
        .ok_or(RunError::NoDisplay)
        .and_then(|display| run(&membership, &display, options));
    exit(NAME, result)
}
