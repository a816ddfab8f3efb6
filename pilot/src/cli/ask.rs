//! Questions to the processes of a run, from another process.

use std::time::Duration;

use bus::Bus;
use bus::message::Command;
use bus::port::CommandClient;
use bus::run::{RunContext, RunError as FolderError, RunLock, run_dir};

use crate::cli::error::CliError;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(15);

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
