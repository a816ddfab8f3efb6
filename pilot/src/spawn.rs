//! The supervisor's hands: starting programs, asking them to end, killing them, noticing that they have ended.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Output, Stdio};

use bus::life::LifeSigns;
use bus::port::HandedVolume;
use bus::process::FACTS_VARIABLE;
use rustix::process::{Pid, Signal, kill_process};

use crate::plan::Planned;
use crate::supervise::Ending;

/// Why a program was not started.
#[derive(Debug, thiserror::Error)]
#[error(
    "starting {program}: {source}. Every program of Trocar lies in one folder; `cargo build --release` makes them all"
)]
pub(crate) struct SpawnError {
    program: PathBuf,
    source: io::Error,
}

/// A program that was started and may still run. Dropped, it is killed: nothing outlives the pilot.
#[derive(Debug)]
pub(crate) struct Running {
    child: Child,
    life: LifeSigns,
}

/// The folder of this very program: its siblings were built with it.
fn sibling(binary: &str) -> PathBuf {
    let folder = std::env::current_exe()
        .ok()
        .and_then(|exe| exe.parent().map(Path::to_owned));
    folder.unwrap_or_default().join(binary)
}

/// Runs a sibling to its end; what it has to say on stderr goes where the pilot's words go.
pub(crate) fn ask(binary: &str, arguments: &[&OsStr]) -> (PathBuf, io::Result<Output>) {
    ask_with(binary, arguments, Stdio::inherit())
}

/// The same, for who makes nothing of what it says.
pub(crate) fn ask_quietly(binary: &str, arguments: &[&OsStr]) -> io::Result<Output> {
    ask_with(binary, arguments, Stdio::null()).1
}

fn ask_with(binary: &str, arguments: &[&OsStr], stderr: Stdio) -> (PathBuf, io::Result<Output>) {
    let program = sibling(binary);
    #[allow(clippy::disallowed_methods, reason = "this is the one place that starts processes")]
    let mut command = std::process::Command::new(&program);
    command.args(arguments).stdin(Stdio::null()).stderr(stderr);
    let output = command.output();
    (program, output)
}

/// Runs a sibling to its end on this program's own terminal.
pub(crate) fn hand_over(binary: &str, arguments: &[OsString]) -> Result<ExitStatus, SpawnError> {
    let program = sibling(binary);
    #[allow(clippy::disallowed_methods, reason = "this is the one place that starts processes")]
    let mut command = std::process::Command::new(&program);
    command
        .args(arguments)
        .status()
        .map_err(|source| SpawnError { program, source })
}

/// What a process is told of the run that it is started in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RunOfProcess<'a> {
    pub(crate) run_dir: &'a Path,
    /// The hash of the run's files.
    pub(crate) facts: &'a str,
    /// The run's volume, where it has one and the process reads it.
    pub(crate) volume: Option<&'a HandedVolume>,
}

/// Starts `planned` in a run; `more` is appended to its arguments.
pub(crate) fn start(planned: &Planned, told: RunOfProcess<'_>, more: &[String]) -> Result<Running, SpawnError> {
    let program = sibling(planned.binary);
    #[allow(clippy::disallowed_methods, reason = "this is the one place that starts processes")]
    let mut command = std::process::Command::new(&program);
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Graphics drivers look for a display there, and complain on stderr where there is no such folder.
        command.env("XDG_RUNTIME_DIR", told.run_dir);
    }
    let fail = |source| SpawnError {
        program: program.clone(),
        source,
    };
    let (life, stdout) = LifeSigns::new().map_err(fail)?;
    command.stdin(Stdio::null());
    if let Some(volume) = told.volume {
        volume.give_to(&mut command).map_err(fail)?;
    }
    let child = command
        .env(FACTS_VARIABLE, told.facts)
        .args(&planned.arguments)
        .args(more)
        .arg("--run-dir")
        .arg(told.run_dir)
        .args(["--parent", &std::process::id().to_string()])
        .stdout(Stdio::from(stdout))
        .spawn()
        .map_err(fail)?;
    Ok(Running { child, life })
}

/// Attaches `file` to a whole recording with a program of its own, as only the recorder knows such files, and waits for it.
/// What it says goes to stderr; whether it succeeded is given back.
pub(crate) fn attach(session: &Path, file: &Path) -> Result<bool, SpawnError> {
    let program = sibling("recorder");
    #[allow(clippy::disallowed_methods, reason = "this is the one place that starts processes")]
    let mut command = std::process::Command::new(&program);
    let status = command
        .arg("attach")
        .args([session, file])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .map_err(|source| SpawnError { program, source })?;
    Ok(status.success())
}

impl Running {
    /// The process's number.
    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Whether it gave a sign of life before it was on the bus, since the last call.
    pub(crate) fn gave_sign(&mut self) -> bool {
        self.life.came()
    }

    /// Asks the process to end.
    pub(crate) fn terminate(&self) {
        if let Some(pid) = i32::try_from(self.pid()).ok().and_then(Pid::from_raw) {
            // It may have ended by itself: the next look says so.
            let _ = kill_process(pid, Signal::TERM);
        }
    }

    /// Ends the process.
    pub(crate) fn kill(&mut self) {
        let _ = self.child.kill();
    }

    /// How the process ended, if it has.
    pub(crate) fn ending(&mut self) -> Option<Ending> {
        let status = self.child.try_wait().ok()??;
        Some(match (status.code(), status.signal()) {
            (Some(code), _) => Ending::Code(code),
            (None, signal) => Ending::Signal(signal.unwrap_or(0)),
        })
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.kill();
        let _ = self.child.wait();
    }
}
