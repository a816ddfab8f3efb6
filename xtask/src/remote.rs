//! `remote-proc`, which is a workspace of its own: building it for use, and testing it where it or what it rests on has changed.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::failure::Failure;
use crate::python::INTERPRETER_VARIABLE;
use crate::shell::{cargo, program, root, run, said, say, target};
use crate::steps::Steps;

const MANIFEST: &str = "remote-proc/Cargo.toml";
/// What a receiver's truth rests on: with these as they were, it works as it did.
const RESTS_ON: [&str; 6] = [
    "remote-proc/Cargo.toml",
    "remote-proc/Cargo.lock",
    "remote-proc/src",
    "remote-proc/tests",
    "crates/bus/src",
    "crates/geometry/src",
];
/// The fingerprint of the above when all of it passed last.
const TESTED: &str = "remote-proc/tested";
/// Names the folder of the other programs to the tests.
const PROGRAMS_VARIABLE: &str = "TROCAR_PROGRAMS";

/// Builds it in release, and puts it beside its siblings, where the pilot finds it.
///
/// # Errors
/// [`Failure`].
pub(crate) fn build() -> Result<(), Failure> {
    run(&mut cargo(&["build", "--release", "--manifest-path", MANIFEST]))?;
    let made = beside("release")?;
    say(&format!("xtask remote: {}", made.display()));
    Ok(())
}

/// Builds it for development, and tests it between real runs.
///
/// # Errors
/// [`Failure`].
pub(crate) fn test(arguments: &[String]) -> Result<(), Failure> {
    let interpreter = std::env::var_os(INTERPRETER_VARIABLE).map(PathBuf::from);
    match arguments {
        [] => tested(interpreter.as_deref()),
        [flag] if flag == "--if-changed" => test_if_changed(interpreter.as_deref()),
        [other, ..] => Err(Failure::Usage(format!(
            "`cargo xtask test-remote` takes --if-changed or nothing, found {other:?}"
        ))),
    }
}

/// The same, unless it passed as it is.
pub(crate) fn test_if_changed(interpreter: Option<&Path>) -> Result<(), Failure> {
    let recorded = fs::read_to_string(root().join(TESTED)).unwrap_or_default();
    if fingerprint().is_ok_and(|now| now == recorded.trim()) {
        say(&format!(
            "SKIPPED: remote-proc, the bus and geometry are those that passed ({TESTED}); `cargo xtask test-remote` tests them anyway"
        ));
        return Ok(());
    }
    tested(interpreter)
}

fn tested(interpreter: Option<&Path>) -> Result<(), Failure> {
    let mut steps = Steps::default();
    let of = |arguments: &[&str]| {
        let mut command = cargo(&arguments[..1]);
        command.args(["--manifest-path", MANIFEST]).args(&arguments[1..]);
        command
    };
    steps.step("formatting", || run(&mut of(&["fmt", "--check"])))?;
    steps.step("lints", || {
        run(&mut of(&["clippy", "--all-targets", "--", "-D", "warnings"]))
    })?;
    steps.step("the other programs", || run(&mut cargo(&["build", "--bins"])))?;
    steps.step("remote-proc", || {
        run(&mut of(&["build"]))?;
        beside("debug").map(drop)
    })?;
    let mut tests = of(&["test"]);
    tests.env(PROGRAMS_VARIABLE, target().join("debug"));
    match interpreter {
        Some(interpreter) => tests.env(INTERPRETER_VARIABLE, interpreter),
        None => tests.env_remove(INTERPRETER_VARIABLE),
    };
    steps.step("tests", || run(&mut tests))?;
    // Without Git nobody can say what was tested, and nothing is skipped.
    if let Ok(fingerprint) = fingerprint() {
        let written = fs::write(root().join(TESTED), format!("{fingerprint}\n"));
        written.map_err(|source| Failure::Start {
            program: TESTED.to_owned(),
            source,
        })?;
    }
    say(&format!("xtask test-remote: {}", steps.summary()));
    Ok(())
}

/// Copies the program beside its siblings of the same profile.
fn beside(profile: &str) -> Result<PathBuf, Failure> {
    let made = root().join("remote-proc/target").join(profile).join("remote-proc");
    let place = target().join(profile).join("remote-proc");
    let copied = fs::create_dir_all(target().join(profile)).and_then(|()| match fs::remove_file(&place) {
        // One that runs goes on; a new file takes its name.
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => fs::copy(&made, &place),
    });
    copied.map_err(|source| Failure::Start {
        program: place.display().to_string(),
        source,
    })?;
    Ok(place)
}

/// A hash of what it rests on, as it lies in the folder, by Git.
fn fingerprint() -> Result<String, Failure> {
    let list = said(program("git", &["ls-files", "--cached", "--others", "--exclude-standard", "--"]).args(RESTS_ON))?;
    let mut paths: Vec<&str> = list.lines().filter(|path| root().join(path).is_file()).collect();
    paths.sort_unstable();
    let hashes = fed(&["hash-object", "--stdin-paths"], &paths.join("\n"))?;
    let named: Vec<String> = paths
        .iter()
        .zip(hashes.lines())
        .map(|(path, hash)| format!("{hash} {path}"))
        .collect();
    Ok(fed(&["hash-object", "--stdin"], &named.join("\n"))?.trim().to_owned())
}

/// What Git says of `text`.
fn fed(arguments: &[&str], text: &str) -> Result<String, Failure> {
    let fail = |source| Failure::Start {
        program: "git".to_owned(),
        source,
    };
    let mut command = program("git", arguments);
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(fail)?;
    let fed = child.stdin.take().map(|mut stdin| stdin.write_all(text.as_bytes()));
    fed.transpose().map_err(fail)?;
    let output = child.wait_with_output().map_err(fail)?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
