//! The command line.

pub(crate) mod ask;
pub(crate) mod calibrate;
pub(crate) mod duration;
pub(crate) mod error;
pub(crate) mod guide;
mod help;
pub(crate) mod plan;
pub(crate) mod steps;
pub(crate) mod stop;
pub(crate) mod study;
pub(crate) mod template;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use bus::message::{Command, CommandKind};
use bus::process::exit;
use bus::topic::TOPICS;
use clap::{Parser, Subcommand};
use scene::raw::Source;
use scene::{Scene, TrackerSource};

use crate::check;
pub use crate::check::Depth;
use crate::cli::ask::ask_process;
use crate::cli::calibrate::{CALIBRATE_HELP, CalibrateArgs, calibrate};
use crate::cli::error::CliError;
use crate::cli::guide::GuideVerb;
use crate::cli::plan::{PLAN_HELP, PlanArgs, Planned};
use crate::cli::steps::{STEPS_HELP, StepsArgs};
use crate::cli::study::{STUDY_HELP, StudyArgs, study};
use crate::cli::template::{NEW_HELP, NewArgs};
use crate::remote::{self, RemoteArgs};
use crate::replay::control::{Steer, steer};
use crate::replay::{ReplayArgs, prepare};
use crate::resolve::{Overrides, ResolveError, resolve, tied};
use crate::run::run;
use crate::state::Options;
use crate::status::Status;
pub use plan::{Hands, LoadTold, NamedPlace, StructureSet};

use help::{
    CHECK_HELP, CONTROL_HELP, REMOTE_HELP, REPLAY_HELP, RESTART_HELP, RUN_HELP, STATUS_HELP, STOP_HELP, TOPICS_HELP,
};

/// Exit code of a run that went to its end with something wrong: see `problems` in its report.
const WITH_PROBLEMS: u8 = 3;

/// Starts, watches and stops a navigation. Trocar is research software and not a medical device.
#[derive(Debug, Parser)]
#[command(
    name = "pilot",
    version,
    after_help = "Examples:\n  \
    pilot run --for 10s --out out                        the embedded demonstration\n  \
    pilot run config/demo.toml --volume ct.nii.gz --headless --for 10s --out out\n  \
    pilot new scene.toml                                 writes a scene with every key explained\n  \
    pilot check config/demo.toml                         reads a scene and says what it would start\n  \
    pilot status                                         what the processes and views of a run do\n  \
    pilot stop                                           ends a run in an orderly way\n  \
    pilot choose para-aortic-left                        the target that is aimed at\n  \
    pilot mark first biopsy taken                        notes the moment in the recording\n  \
    pilot restart recorder                               brings a process back that ended too often\n  \
    pilot calibrate pivot --out tip.json                 finds the tip of the run's instrument\n  \
    pilot plan plan.json --volume ct --window            plans an operation on a screen\n  \
    pilot replay out/session.mcap                        shows a recorded session again\n  \
    pilot remote tls/or3:7447 --keys keys --window       the run of another machine on a second screen\n  \
    pilot study config/study/small.toml --out DIR        whole operations in silico, held against the truth\n\n\
    Exit codes: 0 all well; 1 refused or failed; 3 the run went to its end, but see `problems` in report.json."
)]
struct Cli {
    #[command(subcommand)]
    command: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Runs a scene: starts its processes, navigates, writes pictures, recording and report.
    #[command(after_help = RUN_HELP)]
    Run(RunArgs),
    /// Writes a scene to begin with: every key, with what it does.
    #[command(after_help = NEW_HELP)]
    New(NewArgs),
    /// Reads a scene and everything that it names, and says what it would start, or all that is wrong with it.
    #[command(after_help = CHECK_HELP)]
    Check(CheckArgs),
    /// Prints the state of a run.
    #[command(after_help = STATUS_HELP)]
    Status {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Ends a run in an orderly way.
    #[command(after_help = STOP_HELP)]
    Stop {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Starts a process again that ended too often and was left alone, or the localizer at any time.
    #[command(after_help = RESTART_HELP)]
    Restart {
        /// Its name, as `pilot status` lists it.
        process: String,
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    #[command(flatten)]
    Guide(GuideVerb),
    /// Calibrates, registers and checks in a run that is going, step by step, as its scene's [steps] say.
    #[command(after_help = STEPS_HELP)]
    Steps(StepsArgs),
    /// Makes a plan of an operation, on a screen or from the command line, and says what speaks against it.
    #[command(after_help = PLAN_HELP)]
    Plan(Box<PlanArgs>),
    /// Shows a recorded session again: its poses, at their own times, in the examination that it was recorded in.
    #[command(after_help = REPLAY_HELP)]
    Replay(ReplayArgs),
    /// Shows the run of another machine here: its poses, live, in its examination. Nothing goes back to it.
    #[command(after_help = REMOTE_HELP)]
    Remote(RemoteArgs),
    /// Steers a replay that is going.
    #[command(after_help = CONTROL_HELP)]
    ReplayControl {
        /// The run.
        #[arg(long, default_value = "replay", global = true)]
        run: String,
        #[command(subcommand)]
        steer: Steer,
    },
    /// Calibrates in a run that is going: the tip, the shaft, touched points, the check of a registration.
    #[command(after_help = CALIBRATE_HELP, disable_help_flag = true)]
    Calibrate(CalibrateArgs),
    /// Does whole operations in silico, and holds the predicted error against the true one.
    #[command(after_help = STUDY_HELP)]
    Study(StudyArgs),
    /// Prints the table of topics.
    #[command(after_help = TOPICS_HELP)]
    Topics,
}

#[derive(Debug, clap::Args)]
struct SceneArgs {
    /// The scene file; without one, the embedded demonstration.
    scene: Option<PathBuf>,
    #[command(flatten)]
    volume: VolumeArgs,
}

#[derive(Debug, clap::Args)]
struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Leaves out the meshing of the organs of [tissue].
    #[arg(long)]
    quick: bool,
}

/// Another examination than the scene's.
#[derive(Debug, clap::Args)]
pub(crate) struct VolumeArgs {
    /// Another examination than the scene's: a folder with a DICOM series, a file (.nii, .nii.gz, .nrrd, .nhdr, .mha,
    /// .mhd, an Enhanced CT), or `phantom`.
    #[arg(long)]
    volume: Option<String>,
    /// Which series of that folder, from 1 in the order that the loader lists.
    #[arg(long, value_name = "N", requires = "volume", value_parser = clap::value_parser!(u32).range(1..))]
    series: Option<u32>,
    /// Interpolate its slices to even places where they are not, instead of refusing it; every image says so.
    #[arg(long, requires = "volume")]
    regrid: bool,
    /// Another seed than the scene's.
    #[arg(long)]
    seed: Option<u64>,
}

#[derive(Debug, clap::Args)]
struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// How long to navigate (500ms, 10s, 2m); without it, until stopped.
    #[arg(long = "for", value_name = "TIME", value_parser = duration::parse)]
    duration: Option<Duration>,
    /// In simulated time, as fast as every view draws every pose: on any machine, however busy, the same scene and seed give the
    /// same pictures and recorded poses. For simulated sources, with --for.
    #[arg(long, value_name = "max", value_parser = ["max"], requires = "duration")]
    speed: Option<String>,
    /// Where pictures, recording and report go.
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// Replace a session that is already in the output folder.
    #[arg(long)]
    overwrite: bool,
    /// Opens the operator's window on the display that DISPLAY names, with a second program that reads it back off the screen.
    #[arg(long)]
    window: bool,
    /// No window, whatever else is said. Every run writes its pictures.
    #[arg(long)]
    headless: bool,
    /// Names the run; runs of different names do not see each other.
    #[arg(long, default_value = "default")]
    run: String,
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary.
///
/// `hands` read examinations and label maps.
pub fn main(hands: Hands) -> ExitCode {
    // Recordings, pictures and reports are a patient's: nobody else reads them. What the pilot starts inherits this.
    bus::process::keep_to_oneself();
    match Cli::parse().command {
        Verb::Run(args) => ended(navigate(args, hands)),
        Verb::Replay(args) => ended(show_again(&args, hands)),
        Verb::Remote(args) => ended(show_remote(&args)),
        Verb::ReplayControl { run, steer: how } => exit("pilot", steer(&run, &how).map(|text| say(&text))),
        Verb::New(args) => exit("pilot", args.carry_out().map(|text| say(&text))),
        Verb::Check(args) => exit("pilot", check(&args, hands)),
        Verb::Status { run, json } => exit("pilot", status(&run, json)),
        Verb::Stop { run } => exit("pilot", stop(&run)),
        Verb::Restart { process, run } => exit("pilot", restart(&run, &process)),
        Verb::Plan(args) => ended(plan(&args, hands)),
        Verb::Guide(verb) => exit("pilot", verb.carry_out().map(|text| say(&text))),
        Verb::Calibrate(args) => ended(calibrate(args)),
        Verb::Study(args) => ended(study(&args)),
        Verb::Steps(args) => ended(args.carry_out().map(|(text, code)| {
            say(&text);
            code
        })),
        Verb::Topics => {
            say(&topics());
            ExitCode::SUCCESS
        }
    }
}

fn ended(result: Result<ExitCode, CliError>) -> ExitCode {
    result.unwrap_or_else(|error| exit("pilot", Err(error)))
}

/// What the user asked for goes to stdout; a reader that has closed it (`pilot check | head -1`) wants no more.
fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

impl VolumeArgs {
    /// The scene of this file, or the embedded one, with this examination.
    pub(crate) fn load(&self, scene: Option<&Path>, is_planning: bool) -> Result<(Source, Scene), ResolveError> {
        let overrides = Overrides {
            is_planning,
            volume: self.volume.clone(),
            series: self.series,
            regrid: self.regrid,
            seed: self.seed,
        };
        resolve(scene, &overrides)
    }
}

fn load_scene(args: &SceneArgs) -> Result<(Source, Scene), ResolveError> {
    args.volume.load(args.scene.as_deref(), false)
}

fn plan(args: &PlanArgs, hands: Hands) -> Result<ExitCode, CliError> {
    match args.carry_out(hands)? {
        Planned::Said(words, is_doubtful) => {
            say(&words);
            Ok(match is_doubtful {
                true => ExitCode::from(WITH_PROBLEMS),
                false => ExitCode::SUCCESS,
            })
        }
        Planned::Window(prepared) => {
            let (options, source, scene) = *prepared;
            run(options, source, scene)?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn navigate(args: RunArgs, hands: Hands) -> Result<ExitCode, CliError> {
    let (mut source, mut scene) = load_scene(&args.scene)?;
    no_faults(check::cheap_faults(&source, &scene))?;
    if args.speed.is_some() {
        simulated_time_for(&scene)?;
    }
    if scene.recording.is_some() {
        tied::write(&mut source.scene, &scene, hands.load_labels)?;
        scene = Scene::from_raw(&source).map_err(ResolveError::from)?;
    }
    let options = Options {
        run: args.run,
        out: args.out,
        overwrite: args.overwrite,
        duration: args.duration,
        simulated_time: args.speed.is_some(),
        has_window: args.window && !args.headless,
        replay: None,
        remote: None,
        planning: None,
    };
    carry_out(options, source, scene, "pictures, recording and report")
}

/// Another program publishes at its own pace, which nobody here can make up.
fn simulated_time_for(scene: &Scene) -> Result<(), CliError> {
    match &scene.tracker.source {
        TrackerSource::External => Err(CliError::NotSimulated("external")),
        TrackerSource::Emitters(_) => Err(CliError::NotSimulated("emitters")),
        TrackerSource::Markers(_) => Err(CliError::NotSimulated("markers")),
        TrackerSource::OperatingRoom(room) if room.probe.is_some() => Err(CliError::ProbeInSimulatedTime),
        TrackerSource::Simulated(_) | TrackerSource::OperatingRoom(_) | TrackerSource::Sequence(_) => Ok(()),
    }
}

fn show_again(args: &ReplayArgs, hands: Hands) -> Result<ExitCode, CliError> {
    let (options, source, scene) = prepare(args, hands.load_labels)?;
    carry_out(options, source, scene, "pictures and report")
}

fn show_remote(args: &RemoteArgs) -> Result<ExitCode, CliError> {
    let (options, source, scene) = remote::prepare(args)?;
    carry_out(options, source, scene, "pictures and report")
}

fn carry_out(options: Options, source: Source, scene: Scene, written: &str) -> Result<ExitCode, CliError> {
    let out = options.out.clone();
    let report = run(options, source, scene)?;
    say(&report.table());
    say(&format!("{written}: {}", display(&out)));
    Ok(match report.problems.is_empty() {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(WITH_PROBLEMS),
    })
}

fn display(path: &Path) -> String {
    std::path::absolute(path)
        .unwrap_or_else(|_| path.to_owned())
        .display()
        .to_string()
}

fn check(args: &CheckArgs, hands: Hands) -> Result<(), CliError> {
    let (source, scene) = load_scene(&args.scene)?;
    let found = check::check(
        &source,
        &scene,
        args.quick,
        (hands.organs, hands.tank, hands.load_labels),
    );
    let path = source.path.display();
    match found.faults.len() {
        0 => say(&format!("scene {path}: good")),
        faults => say(&format!("scene {path}: {faults} wrong")),
    }
    say(&found.lines.join("\n"));
    no_faults(found.faults)
}

/// All of them at once, so that they are put right at once.
fn no_faults(faults: Vec<String>) -> Result<(), CliError> {
    match faults.is_empty() {
        true => Ok(()),
        false => Err(CliError::Faults(faults.join("; "))),
    }
}

fn ask(run: &str, command: Command) -> Result<String, CliError> {
    ask_process(run, "pilot", command, |_| Ok(()))
}

fn status_of(run: &str) -> Result<(String, Status), CliError> {
    let text = ask(run, Command::new(CommandKind::Status))?;
    let status = serde_json::from_str(&text).map_err(|_| CliError::NoStatus(run.to_owned()))?;
    Ok((text, status))
}

fn status(run: &str, json: bool) -> Result<(), CliError> {
    let (text, status) = status_of(run)?;
    say(&if json { text } else { status.table() });
    Ok(())
}

fn stop(run: &str) -> Result<(), CliError> {
    say(&crate::cli::stop::stop(run)?);
    Ok(())
}

fn restart(run: &str, process: &str) -> Result<(), CliError> {
    let (_, status) = status_of(run)?;
    let names: Vec<&str> = status.processes.iter().map(|p| p.name.as_str()).collect();
    if !names.contains(&process) {
        return Err(CliError::NoProcess {
            run: run.to_owned(),
            process: process.to_owned(),
            names: names.join(", "),
        });
    }
    say(&ask(run, Command::with_text(CommandKind::Restart, process))?);
    Ok(())
}

fn topics() -> String {
    let mut lines = vec![format!(
        "{:<14}{:<48}{:>7}{:>8}{:>10}  {}",
        "topic", "payload", "writers", "history", "deadline", "for"
    )];
    for topic in TOPICS {
        let deadline = topic
            .deadline
            .map_or("-".to_owned(), |d| format!("{} ms", d.as_millis()));
        lines.push(format!(
            "{:<14}{:<48}{:>7}{:>8}{deadline:>10}  {}",
            topic.name, topic.payload, topic.publishers, topic.history, topic.purpose
        ));
    }
    lines.join("\n")
}
