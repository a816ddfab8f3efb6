//! Why the command line did not do what it was asked.

use bus::BusError;
use bus::run::RunError as FolderError;

use crate::cli::plan::PlanCliError;
use crate::remote::RemoteError;
use crate::replay::PrepareError;
use crate::resolve::ResolveError;
use crate::resolve::tied::OtherFile;
use crate::run::RunError;
use crate::spawn::SpawnError;

/// Why the command line did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    #[error(transparent)]
    Remote(#[from] RemoteError),
    #[error("run {0:?} is not a replay: there is nothing to steer. `pilot replay FILE` starts one")]
    NoReplay(String),
    #[error(transparent)]
    Resolve(#[from] ResolveError),
    #[error(transparent)]
    Tied(#[from] OtherFile),
    #[error(transparent)]
    Plan(#[from] PlanCliError),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Spawn(#[from] SpawnError),
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error(transparent)]
    Bus(#[from] BusError),
    #[error(
        "--speed max runs in simulated time, and the scene says tracker.source = {0:?}: another program publishes at its own \
         pace. Needed is \"simulated\", \"operating-room\" or \"sequence\""
    )]
    NotSimulated(&'static str),
    #[error(
        "--speed max runs in simulated time, and the scene has a tracker.room.probe, whose images come at their own pace. Leave \
         the probe out, or run without --speed max"
    )]
    ProbeInSimulatedTime,
    #[error("{0}")]
    Faults(String),
    #[error("run {run:?} refused: {why}")]
    Refused { run: String, why: String },
    #[error("run {run:?} has no process {process:?}; it has {names}")]
    NoProcess {
        run: String,
        process: String,
        names: String,
    },
    #[error("the words have {found} bytes; at most {most} go with a request")]
    TooLong { found: usize, most: usize },
    #[error("run {0:?} has published no pose yet: there is nothing to hold")]
    NoPose(String),
    #[error(
        "run {0:?} has no steps to be taken: its scene has no table [steps], or it is a replay or in simulated time, or its process \
         `calib` has not come up yet"
    )]
    NoSteps(String),
    #[error("`point` needs the number of a point, from 1")]
    NoPoint,
    #[error("{0} is of no meaning here: a number goes with `point` alone")]
    Number(u32),
    #[error("run {0:?} answered with something that is not a status")]
    NoStatus(String),
}
