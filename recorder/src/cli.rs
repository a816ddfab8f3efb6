//! The command line.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, Process, exit};
use clap::{Args, Parser, Subcommand};

mod stretch;
mod tools;

use crate::damage::OpenError;
use crate::info::info;
use crate::record::{RecordError, record};
use crate::recover::{RecoverError, recover, target};
use tools::{Tool, ToolError};

/// Records a run to MCAP, and reads, checks, cuts and translates such files.
#[derive(Debug, Parser)]
#[command(name = "recorder", version, after_help = TOP_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const TOP_HELP: &str = "\
While it grows, a recording is named FILE.mcap.recording; only a whole one is named FILE.mcap.

Examples:
  recorder info session.mcap
  recorder verify session.mcap
  recorder export csv session.mcap --out poses.csv
  recorder cut session.mcap --from 3.2s --to 9s --out insertion.mcap
  recorder recover session.mcap.recording";

const RECORD_HELP: &str = "\
The pilot starts this. Poses are on disk one chunk ([recording] chunk_s of the scene) after they came, whatever kills \
the process. SIGTERM completes the file. What an earlier, killed recorder of the same file left becomes FILE.1.mcap, \
FILE.2.mcap...

Example:
  recorder record --run-dir /run/user/1000/trocar/demo --out session.mcap";

const RECOVER_HELP: &str = "\
The old file stays as it is. Exit code 0 also where parts were unreadable: which, is said.

Examples:
  recorder recover session.mcap.recording
  recorder recover damaged.mcap --out rescued.mcap";

const INFO_HELP: &str = "\
Works on unfinished and damaged files too, and says what is wrong with them. `gaps` are places where sequence numbers \
were left out, `missing` how many; `restarts` are places where they began anew. The table of times has the intervals \
between neighbouring captures (its spread is the jitter) and the latency from capture to publication; percentiles to \
0.5 %. Then come the longest times without a pose.

Example:
  recorder info session.mcap";

#[derive(Debug, Subcommand)]
enum Command {
    /// Record a run until asked to stop
    #[command(after_help = RECORD_HELP)]
    Record(RecordArgs),
    /// Make a whole file of everything readable in an unfinished or damaged one
    #[command(after_help = RECOVER_HELP)]
    Recover(RecoverArgs),
    #[command(flatten)]
    Tool(Tool),
    /// Show what a recording holds
    #[command(after_help = INFO_HELP)]
    Info {
        /// The recording
        file: PathBuf,
    },
}

#[derive(Debug, Args)]
struct RecordArgs {
    /// The run's folder
    #[arg(long, value_name = "DIR")]
    run_dir: PathBuf,
    /// The pilot's process: this one ends with it
    #[arg(long, value_name = "PID")]
    parent: Option<u32>,
    /// The recording; never overwritten: where it exists, FILE.1.mcap is made
    #[arg(long, value_name = "FILE.mcap")]
    out: PathBuf,
}

#[derive(Debug, Args)]
struct RecoverArgs {
    /// The unfinished or damaged recording
    input: PathBuf,
    /// The whole file [default: the input without .recording]
    #[arg(long, value_name = "FILE.mcap")]
    out: Option<PathBuf>,
    /// Replace the whole file if it exists
    #[arg(long)]
    force: bool,
}

#[derive(Debug, thiserror::Error)]
enum CliError {
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error(transparent)]
    Recover(#[from] RecoverError),
    #[error(transparent)]
    Open(#[from] OpenError),
    #[error(transparent)]
    Tool(#[from] ToolError),
}

/// Runs the `recorder` command line of this process.
pub fn main() -> ExitCode {
    exit("recorder", run(Cli::parse().command))
}

fn run(command: Command) -> Result<(), CliError> {
    match command {
        Command::Record(args) => {
            let (run_dir, parent) = (args.run_dir, args.parent);
            let joined = Process::join("recorder", &Membership { run_dir, parent });
            let finished = record(&mut joined.map_err(RecordError::Join)?, &args.out)?;
            say(&format!(
                "{}: {} messages\n",
                finished.path.display(),
                finished.messages
            ));
        }
        Command::Recover(args) => {
            let out = target(&args.input, args.out, args.force)?;
            let info = recover(&args.input, &out)?;
            say(&format!(
                "recovered {} messages into {}\n{info}",
                info.tally.messages(),
                out.display()
            ));
        }
        Command::Tool(tool) => say(&tools::run(tool)?),
        Command::Info { file } => {
            let info = info(&file)?;
            say(&format!("{}\n{info}", file.display()));
        }
    }
    Ok(())
}

/// Where nobody reads stdout any more, there is nobody to tell.
fn say(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent_and_shows_examples() {
        let mut command = Cli::command();
        command.clone().debug_assert();
        for name in [
            "record", "recover", "info", "export", "import", "cut", "verify", "attach",
        ] {
            let help = command.find_subcommand_mut(name).unwrap().render_help().to_string();
            assert!(help.contains("Example"), "{help}");
        }
    }

    #[test]
    fn the_pilots_call_is_understood() {
        let cli = Cli::try_parse_from([
            "recorder",
            "record",
            "--run-dir",
            "/r",
            "--parent",
            "7",
            "--out",
            "s.mcap",
        ]);
        assert!(matches!(cli.unwrap().command, Command::Record(args) if args.parent == Some(7)));
    }
}
