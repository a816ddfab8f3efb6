//! Everything that must pass, and the part of it that is quick.

use std::num::NonZero;

use crate::failure::Failure;
use crate::python::{self, INTERPRETER_VARIABLE};
use crate::remote;
use crate::shell::{cargo, run, say};
use crate::steps::Steps;

/// How many tests of an executable run at once, where it is set.
const THREADS: &str = "RUST_TEST_THREADS";

fn no_arguments(chore: &str, arguments: &[String]) -> Result<(), Failure> {
    let Some(first) = arguments.first() else { return Ok(()) };
    Err(Failure::Usage(format!(
        "`cargo xtask {chore}` takes no arguments, found {first:?}; for a single test use `cargo test NAME`"
    )))
}

fn style(steps: &mut Steps) -> Result<(), Failure> {
    steps.step("formatting", || run(&mut cargo(&["fmt", "--all", "--check"])))?;
    let lints = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    steps.step("lints", || run(&mut cargo(&lints)))?;
    // What the demonstration builds.
    let navigation = ["clippy", "--bins", "--no-default-features", "--", "-D", "warnings"];
    steps.step("a navigation alone", || run(&mut cargo(&navigation)))
}

/// Formatting, lints, and the tests beside the code and of the house: no process is started, no Python asked for.
///
/// # Errors
/// [`Failure::Step`], [`Failure::Usage`].
pub(crate) fn check(arguments: &[String]) -> Result<(), Failure> {
    no_arguments("check", arguments)?;
    let mut steps = Steps::default();
    style(&mut steps)?;
    let tests = ["test", "--workspace", "--lib", "--test", "structure"];
    steps.step("tests beside the code", || run(&mut cargo(&tests)))?;
    say(&format!(
        "xtask check: {}; `cargo xtask test` runs the rest",
        steps.summary()
    ));
    Ok(())
}

/// Formatting, lints, documentation and tests, in this order, up to the first failure.
///
/// # Errors
/// [`Failure::Step`], [`Failure::Usage`].
pub(crate) fn test(arguments: &[String]) -> Result<(), Failure> {
    no_arguments("test", arguments)?;
    let mut steps = Steps::default();
    style(&mut steps)?;
    steps.step("documentation", || {
        run(cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
    })?;
    let interpreter = steps.step("python", || Ok(python::prepare()))?;
    let mut tests = cargo(&["test", "--workspace"]);
    // Tests that start processes wait for them most of their time (on two processors, three at a time used 45 % of both): two more at a
    // time than there are processors.
    if std::env::var_os(THREADS).is_none() {
        let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
        tests.env(THREADS, (processors + 2).to_string());
    }
    let remark = match &interpreter {
        Ok(interpreter) => {
            tests.env(INTERPRETER_VARIABLE, interpreter);
            String::new()
        }
        Err(reason) => {
            say(&format!(
                "no Python for the tests that compare with other software, they are skipped: {reason}"
            ));
            tests.env_remove(INTERPRETER_VARIABLE);
            ". Tests that need Python were skipped".to_owned()
        }
    };
    steps.step("tests", || run(&mut tests))?;
    steps.step("a second machine", || {
        remote::test_if_changed(interpreter.as_deref().ok())
    })?;
    say(&format!("xtask test: {}{remark}", steps.summary()));
    Ok(())
}
