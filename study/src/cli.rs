//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use crate::plan::Plan;
use crate::record::Row;
use crate::report;
use crate::run::run_telling;
use crate::worst;

const HELP: &str = "\
Every operation goes the whole way in silico, by the functions and files of the real chain and in virtual time: the tool's marker is \
calibrated from frames of its emitters, the tip by pivoting, the tool in its seat on the base; beads are found in the image of a CT and \
touched; the patient is registered and the registration checked; then a scripted hand steers to each target by the sight, or with display = \"pixels\" \
by what stands in the pixels of the window. The truth is the simulator's. What comes out is held against what was predicted. With registration = \"surface\" a tracked ultrasound probe sees the pelvis in the \
place of the beads, and bone from the CT's image is registered to its images.

DIR gets operations.csv (a line for each target of each operation), report.html with its charts, tables.md, and worst/: the worst operations as \
recordings, each with its command in report.html. A study that was killed goes on \
where it was; the same files give the same bytes. Examinations are made once for some operations (ct.images) and are kept in \
DIR/images by the hash of what they are made of; ct.fresh = true makes one for each operation.

A study file:
  seed = 1
  operations = 100               # of each stratum
  display = \"sight\"              # or \"pixels\"
  [all]                          # what holds for all strata; all keys have a usual value
  localizer = { across_mm = 0.1, depth_mm = 0.15 }
  [[stratum]]
  name = \"usual\"
  [[stratum]]
  name = \"three-beads\"
  beads = { touched = 3 }
  [sweep]                        # every combination of these values is a stratum
  marker.emitters = [12, 32]
  marker.radius_mm = [25.0, 50.0]

Examples:
  study config/study/small.toml --out DIR
  pilot study config/study/accuracy.toml --out DIR
  pilot study config/study/surface.toml --out DIR --threads 2
  pilot study config/study/tissue.toml --out DIR --worst 0
  pilot study config/study/*.toml --out DIR      # strata of one name are told as FILE.NAME";

/// Holds the predicted error of whole operations against the true one, in silico
#[derive(Debug, Parser)]
#[command(name = "study", version, after_help = HELP)]
pub(crate) struct Cli {
    /// Study files; all of them together are one study
    #[arg(required = true, value_name = "FILE.toml")]
    files: Vec<PathBuf>,
    /// Where results go; a folder of this study is gone on with
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Operations at a time [default: as many as there are processors]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// So many of the worst operations are done once more and kept as recordings that `pilot replay` shows
    #[arg(long, value_name = "COUNT", default_value_t = 10, value_parser = clap::value_parser!(u8).range(0..=100))]
    worst: u8,
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Runs the `study` command line of this process.
pub fn main() -> ExitCode {
    match carry_out(&Cli::parse()) {
        Ok(text) => {
            bus::stderr_line!("{text}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            bus::stderr_line!("study: error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn carry_out(cli: &Cli) -> Result<String, Box<dyn std::error::Error>> {
    let plan = Plan::load(&cli.files)?;
    let usual = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = cli.threads.map_or(usual, usize::from);
    let mut page = |rows: &[Row]| {
        if let Err(why) = report::write(&cli.out, &plan, rows, &[]) {
            bus::stderr_line!("study: the page was not written: {why}");
        }
    };
    let done = run_telling(&plan, (&cli.out, threads), &mut page)?;
    let kept = worst::keep(&plan, &cli.out, &done.rows, usize::from(cli.worst), threads)?;
    report::write(&cli.out, &plan, &done.rows, &kept)?;
    let [now, before] = done.operations;
    Ok(format!(
        "study: {now} operations in {:.0} s by {threads} threads, {before} were there; {}",
        done.took_s,
        cli.out.join("report.html").display()
    ))
}
