//! Questions to the processes of a run, from another process.

use std::time::Duration;

use bus::Bus;
use bus::clock::{self, monotonic_ns};
use bus::message::{Command, ToolPose};
use bus::port::{CommandClient, Subscriber};
use bus::run::{RunContext, RunError as FolderError, RunLock, run_dir};
use bus::topic::TOOL_POSE;

use crate::cli::error::CliError;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(15);

/// How long a pose may take to come: one that was published before is given at the next turn of its publisher.
const POSE: Duration = Duration::from_secs(2);
const LOOK: Duration = Duration::from_millis(5);

/// The newest pose of a run, be it valid or lost.
pub(crate) fn newest_pose(run: &str) -> Result<ToolPose, CliError> {
    let dir = run_dir(run)?;
    if !RunLock::is_held(&dir) {
        return Err(FolderError::NotRunning { name: run.to_owned() }.into());
    }
    let bus = Bus::operate(&RunContext::load(&dir)?)?;
    let poses = Subscriber::open(&bus, &TOOL_POSE, "", 1)?;
    let until_ns = monotonic_ns() + clock::ns(POSE);
    while monotonic_ns() < until_ns {
        if let Some(pose) = poses.newest()? {
            return Ok(pose);
        }
        std::thread::sleep(LOOK);
    }
    Err(CliError::NoPose(run.to_owned()))
}

/// Asks a process of a run. Where the run's pilot dies before the answer, the run that follows it under the same name is asked.
pub(crate) fn ask_process(
    run: &str,
    process: &str,
    command: Command,
    accepted: impl Fn(&RunContext) -> Result<(), CliError>,
) -> Result<String, CliError> {
    let dir = run_dir(run)?;
    loop {
        if !RunLock::is_held(&dir) {
            return Err(FolderError::NotRunning { name: run.to_owned() }.into());
        }
        let context = RunContext::load(&dir)?;
        accepted(&context)?;
        let bus = Bus::operate(&context)?;
        let client = CommandClient::open(&bus, process)?;
        return match client.ask_while(command, PATIENCE, || context.is_running()) {
            Ok(reply) if reply.refused => Err(CliError::Refused {
                run: run.to_owned(),
                why: reply.text,
            }),
            Ok(reply) => Ok(reply.text),
            Err(_) if !context.is_running() => continue,
            Err(error) => Err(error.into()),
        };
    }
}
