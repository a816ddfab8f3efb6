//! The command line.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, Process, exit};
use clap::{Args, Parser, Subcommand};

pub(crate) mod stretch;
mod tools;

use crate::edit::compare::{self, CompareError, Summary, compare};
use crate::edit::export::follow::FollowMarkers;
use crate::edit::recover::{RecoverError, recover, target};
use crate::read::damage::OpenError;
use crate::read::info::info;
use crate::replay::cli::{REPLAY_HELP, ReplayArgs};
use crate::replay::facts::{FactsError, facts, facts_of_all};
use crate::replay::process::ReplayError;
use crate::wire::schema::{GROUND_TRUTH, TOOL_POSE};
use crate::write::record::{RecordError, record};
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
  recorder report session.mcap --out report.html
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

const FACTS_HELP: &str = "\
Goes by the file's index, where that can be relied on; else the file is read from start to end, and stderr says why. What is \
said: the scene, the run, the examination and the registration, how many poses, \
from when to when (ns on the recorded run's clock), how many frames of emitters, the attached calibrations and \
registrations, and what cannot be read, which only who reads all knows (--whole).

Examples:
  recorder facts session.mcap
  recorder facts session.mcap --whole";

const COMPARE_HELP: &str = "\
Poses belong together by their sequence number. Writes compare.csv (a line for each number: distance and direction between \
the tips, angle between the orientations, the tips themselves), compare.png (over time) and compare.json (rms, 50 %, 95 %, maximum).

Examples:
  recorder compare session.mcap recomputed.mcap --out difference
  recorder compare session.mcap session.mcap --truth --out error   against the simulated truth in the second file";

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
    /// Publish a recording's poses in the place of the tracker
    #[command(after_help = REPLAY_HELP)]
    Replay(ReplayArgs),
    /// Show a run live in Foxglove (a research display)
    #[cfg(feature = "foxglove")]
    #[command(after_help = crate::serve::SERVE_HELP)]
    Serve(crate::serve::ServeArgs),
    /// Say what a replay must know of a recording, as JSON
    #[command(after_help = FACTS_HELP)]
    Facts {
        /// The recording
        file: PathBuf,
        /// Read every message, whatever the index says
        #[arg(long)]
        whole: bool,
    },
    /// Say how far the poses of two recordings lie apart
    #[command(after_help = COMPARE_HELP)]
    Compare(CompareArgs),
}

#[derive(Debug, Args)]
struct CompareArgs {
    /// The one recording
    #[arg(value_name = "A.mcap")]
    a: PathBuf,
    /// The other
    #[arg(value_name = "B.mcap")]
    b: PathBuf,
    /// Where table, chart and summary go
    #[arg(long, value_name = "DIR", default_value = "compare")]
    out: PathBuf,
    /// Compare with the simulated tool's true poses of B instead of its measured ones
    #[arg(long)]
    truth: bool,
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
    #[error(transparent)]
    Facts(#[from] FactsError),
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[cfg(feature = "foxglove")]
    #[error(transparent)]
    Serve(#[from] crate::serve::ServeError),
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Runs the `recorder` command line of this process; `follow` follows the markers of a scene as the tracker does.
pub fn main(follow: FollowMarkers) -> ExitCode {
    exit("recorder", run(Cli::parse().command, follow))
}

fn run(command: Command, follow: FollowMarkers) -> Result<(), CliError> {
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
        Command::Tool(tool) => say(&tools::run(tool, follow)?),
        Command::Info { file } => {
            let info = info(&file)?;
            say(&format!("{}\n{info}", file.display()));
        }
        Command::Replay(args) => crate::replay::cli::run(args)?,
        #[cfg(feature = "foxglove")]
        Command::Serve(args) => crate::serve::serve(&args)?,
        Command::Facts { file, whole } => {
            let found = if whole { facts_of_all(&file)? } else { facts(&file)? };
            let json = serde_json::to_string(&found).unwrap_or_default();
            say(&(json + "\n"));
        }
        Command::Compare(args) => compare_files(&args)?,
    }
    Ok(())
}

fn compare_files(args: &CompareArgs) -> Result<(), CompareError> {
    let topic_b = if args.truth { GROUND_TRUTH } else { TOOL_POSE };
    let compared = compare(&args.a, TOOL_POSE, &args.b, topic_b)?;
    let summary = Summary::of(&compared);
    compare::write(&compared, &summary, &args.out)?;
    say(&format!(
        "{} and {}\n{summary}table, chart and summary: {}\n",
        args.a.display(),
        args.b.display(),
        args.out.display()
    ));
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
        #[cfg(feature = "foxglove")]
        let more = ["serve"];
        #[cfg(not(feature = "foxglove"))]
        let more = [];
        for name in more.into_iter().chain([
            "record", "recover", "info", "export", "import", "cut", "verify", "attach", "replay", "facts", "compare",
            "report",
        ]) {
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
