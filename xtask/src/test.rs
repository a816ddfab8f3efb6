//! Everything that must pass.

use crate::failure::Failure;
use crate::python::{self, INTERPRETER_VARIABLE};
use crate::shell::{cargo, run, say};
use crate::steps::Steps;

/// Formatting, lints, documentation and tests, in this order, up to the first failure.
///
/// # Errors
/// [`Failure::Step`], [`Failure::Usage`].
pub(crate) fn test(arguments: &[String]) -> Result<(), Failure> {
    if let Some(first) = arguments.first() {
        return Err(Failure::Usage(format!(
            "`cargo xtask test` takes no arguments, found {first:?}; for a single test use `cargo test NAME`"
        )));
    }
    let mut steps = Steps::default();
    steps.step("formatting", || run(&mut cargo(&["fmt", "--all", "--check"])))?;
    steps.step("lints", || {
        run(&mut cargo(&[
            "clippy",
            "--workspace",
            "--all-targets",
            "--",
            "-D",
            "warnings",
        ]))
    })?;
    steps.step("documentation", || {
        run(cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
    })?;
    let interpreter = steps.step("python", || Ok(python::prepare()))?;
    let mut tests = cargo(&["test", "--workspace"]);
    let remark = match interpreter {
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
    say(&format!("xtask test: {}{remark}", steps.summary()));
    Ok(())
}
