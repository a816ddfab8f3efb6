//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, exit};
use clap::Parser;

use crate::run::run;

/// Shows the run to 3D Slicer, PLUS and other programs that speak OpenIGTLink.
#[derive(Debug, Parser)]
#[command(
    name = "gateway-proc",
    version,
    after_help = "Nothing that a client sends changes the run. What is served, and how 3D Slicer, PLUS and pyigtl connect: \
    docs/slicer.md.\n\n\
    Example (the pilot starts this process where the scene has a [gateway] table; by hand it joins a run that is going):\n  \
    gateway-proc --run-dir /tmp/trocar-0/default"
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

/// The binary.
pub fn main() -> ExitCode {
    let Cli { run_dir, parent } = Cli::parse();
    exit("gateway-proc", run(&Membership { run_dir, parent }))
}
