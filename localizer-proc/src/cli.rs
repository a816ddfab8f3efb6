//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, exit};
use clap::{Args, CommandFactory as _, Parser, Subcommand};

use crate::decode::{Options, decode};
use crate::run;
use crate::simulate::{Hands, SimulateArgs, simulate};

/// Dials a localizer and publishes the poses of its markers.
#[derive(Debug, Parser)]
#[command(
    name = "localizer-proc",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Examples (the pilot starts this process; by hand it joins a run that is going):\n  \
    localizer-proc --run-dir /tmp/trocar-0/default\n  \
    localizer-proc decode captured.bin              what a peer sent, message by message\n  \
    localizer-proc decode --ndi --json replies.bin  what an NDI device answered, a line each\n  \
    localizer-proc simulate-ndi config/operating-room.toml   a device to practise with\n\n\
    The scene's [localizer] table says what is dialled, and [tracker.markers] which of its tools are meant."
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Debug, Args)]
struct RunArgs {
    /// The run's folder.
    #[arg(long, required = true)]
    run_dir: Option<PathBuf>,
    /// The pilot's process; this one ends with it.
    #[arg(long)]
    parent: Option<u32>,
    /// A person has looked at the peer: what the process before knew of it is forgotten.
    #[arg(long)]
    anew: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Prints recorded bytes as messages with their fields; exit code 1 where one cannot be read
    #[command(after_help = "Examples:\n  \
        localizer-proc decode captured.bin\n  \
        nc 192.168.0.30 18944 | localizer-proc decode -\n\n\
        What cannot be read is printed with the byte at which it is wrong, what was found and what is allowed.")]
    Decode {
        /// Files; `-` is the standard input
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// Replies of an NDI device, not OpenIGTLink
        #[arg(long)]
        ndi: bool,
        /// A line of JSON for each
        #[arg(long)]
        json: bool,
    },
    /// Stands for a device of NDI: answers its combined API over TCP with what the scene's simulated operating room shows
    #[command(
        name = "simulate-ndi",
        after_help = "Examples:\n  \
        localizer-proc simulate-ndi config/operating-room.toml --write-tools .\n  \
        localizer-proc simulate-ndi scene.toml --tool 8700340.rom --patient 8700449.rom\n  \
        localizer-proc simulate-ndi scene.toml --listen 0.0.0.0:8765 --expose\n\n\
        It serves one client at a time, the next one after it; a definition of any tool may be loaded, as what is told is where the\n\
        room's markers are. It simulates: nothing that it says was measured."
    )]
    SimulateNdi(SimulateArgs),
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    Cli::command()
}

/// The binary; `hands` is what this crate may not know.
pub fn main(hands: Hands) -> ExitCode {
    let cli = Cli::parse();
    match cli.command {
        Some(Command::Decode { files, ndi, json }) => {
            let options = Options { ndi, json };
            exit("localizer-proc", decode(&files, options, &mut std::io::stdout().lock()))
        }
        Some(Command::SimulateNdi(args)) => exit("localizer-proc", simulate(&args, hands)),
        None => {
            let membership = Membership {
                run_dir: cli.run.run_dir.unwrap_or_default(),
                parent: cli.run.parent,
            };
            exit("localizer-proc", run::run(&membership, cli.run.anew))
        }
    }
}
