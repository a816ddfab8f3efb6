//! `pilot stop`, also where no place on the bus is left for another client.

use bus::BusError;
use bus::message::{Command, CommandKind};
use bus::run::{RunContext, run_dir};
use rustix::process::{Pid, Signal, kill_process};

use crate::cli::ask::ask_process;
use crate::cli::error::CliError;

/// Asks the pilot of `run` to stop; where it cannot be asked over the bus, by a signal, which it takes alike.
///
/// # Errors
/// As [`ask_process`]; the bus's own where the signal reaches nobody either.
pub(crate) fn stop(run: &str) -> Result<String, CliError> {
    match ask_process(run, "pilot", Command::new(CommandKind::Stop), |_| Ok(())) {
        Err(CliError::Bus(error @ (BusError::Open { .. } | BusError::Join { .. }))) => signal(run, error),
        answer => answer,
    }
}

fn signal(run: &str, error: BusError) -> Result<String, CliError> {
    let context = RunContext::load(&run_dir(run)?)?;
    // The lock says that this process is still the run's pilot.
    let pilot = i32::try_from(context.pilot_pid).ok().and_then(Pid::from_raw);
    match pilot.filter(|_| context.is_running()) {
        Some(pilot) if kill_process(pilot, Signal::TERM).is_ok() => {
            Ok(format!("stopping, by a signal, as the bus has no room: {error}"))
        }
        _ => Err(error.into()),
    }
}
