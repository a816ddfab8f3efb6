//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, exit};
use clap::Parser;

use crate::anatomy::LoadLabels;
use crate::run::run;

/// Moves the organs of the scene's [tissue] table with the tracked tube.
#[derive(Debug, Parser)]
#[command(
    name = "tissue-proc",
    version,
    after_help = "What is modelled, what each state says and what images show of it: docs/tissue.md.\n\n\
    Example (the pilot starts this process where the scene has a [tissue] table; by hand it joins a run that is going):\n  \
    tissue-proc --run-dir /tmp/trocar-0/default"
)]
struct Cli {
    /// The run's folder.
    #[arg(long, value_name = "DIR")]
    run_dir: PathBuf,
    /// The pilot's process; this one ends with it.
    #[arg(long, value_name = "PID")]
    parent: Option<u32>,
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary; `load_labels` reads label maps.
pub fn main(load_labels: LoadLabels) -> ExitCode {
    let Cli { run_dir, parent } = Cli::parse();
    exit("tissue-proc", run(&Membership { run_dir, parent }, load_labels))
}
