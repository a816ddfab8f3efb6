//! The one place that starts programs.

use std::ffi::{OsStr, OsString};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::failure::Failure;

/// A line for the user. Where nobody reads stdout any more, there is nobody to tell.
pub(crate) fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// The repository's root.
pub(crate) fn root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here)
}

/// The folder that the user is in.
pub(crate) fn here() -> PathBuf {
    std::env::current_dir().unwrap_or_else(|_| root().to_owned())
}

/// The build folder: this program lies in `TARGET/debug`.
pub(crate) fn target() -> PathBuf {
    let exe = std::env::current_exe().ok();
    let folder = exe.as_deref().and_then(|exe| exe.parent()?.parent());
    folder.map_or_else(|| root().join("target"), Path::to_owned)
}

/// A program with nothing to read, started in the repository's root.
pub(crate) fn program(name: impl AsRef<OsStr>, arguments: &[&str]) -> Command {
    #[allow(
        clippy::disallowed_methods,
        reason = "chores are about starting programs; this is the one place"
    )]
    let mut command = Command::new(name);
    command.args(arguments).current_dir(root()).stdin(Stdio::null());
    command
}

/// The cargo that runs this chore.
pub(crate) fn cargo(arguments: &[&str]) -> Command {
    program(
        std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo")),
        arguments,
    )
}

/// Runs a program; what it says goes where ours goes.
///
/// # Errors
/// [`Failure::Start`], [`Failure::Ended`].
pub(crate) fn run(command: &mut Command) -> Result<(), Failure> {
    let status = command.status().map_err(|source| not_started(command, source))?;
    match status.success() {
        true => Ok(()),
        false => Err(Failure::Ended {
            command: words(command),
            status,
        }),
    }
}

/// Runs a program quietly. What it said is in the error only.
pub(crate) fn quietly(command: &mut Command) -> Result<(), String> {
    let output = command
        .output()
        .map_err(|source| not_started(command, source).to_string())?;
    match output.status.success() {
        true => Ok(()),
        false => Err(format!(
            "`{}` ended with {}: {}",
            words(command),
            output.status,
            last_words(&output)
        )),
    }
}

/// What a program says on stdout.
///
/// # Errors
/// [`Failure::Start`], [`Failure::Ended`].
pub(crate) fn said(command: &mut Command) -> Result<String, Failure> {
    let output = command.output().map_err(|source| not_started(command, source))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(Failure::Ended {
            command: words(command),
            status: output.status,
        }),
    }
}

fn not_started(command: &Command, source: std::io::Error) -> Failure {
    let program = command.get_program().to_string_lossy().into_owned();
    Failure::Start { program, source }
}

/// The command as one would type it.
fn words(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let all = std::iter::once(program).chain(command.get_args());
    all.map(OsStr::to_string_lossy).collect::<Vec<_>>().join(" ")
}

/// The last line of a program's complaint.
fn last_words(output: &Output) -> String {
    let complaint = if output.stderr.is_empty() {
        &output.stdout
    } else {
        &output.stderr
    };
    let text = String::from_utf8_lossy(complaint);
    text.lines()
        .rev()
        .map(str::trim)
        .find(|line| !line.is_empty())
        .unwrap_or("(silent)")
        .to_owned()
}
