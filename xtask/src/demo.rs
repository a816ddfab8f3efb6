//! The demonstration.

use std::path::Path;

use crate::failure::Failure;
use crate::shell::{cargo, here, program, root, run, say, target};

/// Builds what a navigation needs and runs the embedded scene; `extra` goes to `pilot run`, and paths in it are relative to the
/// folder that the user is in.
///
/// # Errors
/// [`Failure::Start`], [`Failure::Ended`].
pub(crate) fn demo(extra: &[String]) -> Result<(), Failure> {
    // Calibrations and solids are a fifth of a cold build, and no part of this.
    run(&mut cargo(&["build", "--release", "--bins", "--no-default-features"]))?;
    let arguments = arguments(extra, &root().join("out").to_string_lossy());
    let mut pilot = program(target().join("release/pilot"), &[]);
    let navigated = run(pilot.args(&arguments).current_dir(here()));
    if let Some(out) = value_of(&arguments, "--out") {
        point_at(&here().join(out));
    }
    navigated
}

/// `pilot run` with the demonstration's defaults where `extra` says nothing else. A session in a folder that the user
/// named is not overwritten.
fn arguments(extra: &[String], out: &str) -> Vec<String> {
    let mut all: Vec<&str> = vec!["run"];
    let says = |flag: &str| value_of(extra, flag).is_some() || extra.iter().any(|a| a == flag);
    if !says("--headless") {
        all.push("--headless");
    }
    if !says("--for") {
        all.extend(["--for", "10s"]);
    }
    if !says("--out") {
        all.extend(["--out", out]);
        if !says("--overwrite") {
            all.push("--overwrite");
        }
    }
    all.into_iter()
        .map(str::to_owned)
        .chain(extra.iter().cloned())
        .collect()
}

/// The value of `--flag VALUE` or `--flag=VALUE`.
fn value_of<'a>(arguments: &'a [String], flag: &str) -> Option<&'a str> {
    let split = arguments.iter().find_map(|a| a.strip_prefix(flag)?.strip_prefix('='));
    let at = arguments.iter().position(|a| a == flag);
    split.or_else(|| arguments.get(at? + 1).map(String::as_str))
}

fn point_at(out: &Path) {
    let sheet = out.join("sheet.png");
    if sheet.exists() {
        say(&format!("look at {}", sheet.display()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(extra: &str) -> String {
        let extra: Vec<String> = extra.split_whitespace().map(str::to_owned).collect();
        arguments(&extra, "o").join(" ")
    }

    #[test]
    fn defaults_give_way_to_what_is_asked_for() {
        assert_eq!(words(""), "run --headless --for 10s --out o --overwrite");
        assert_eq!(
            words("--for 3s --seed 2"),
            "run --headless --out o --overwrite --for 3s --seed 2"
        );
        assert_eq!(words("--out=x"), "run --headless --for 10s --out=x");
    }

    #[test]
    fn values_are_found_in_both_forms() {
        let arguments = ["--out".to_owned(), "a".to_owned(), "--for=3s".to_owned()];
        assert_eq!(value_of(&arguments, "--out"), Some("a"));
        assert_eq!(value_of(&arguments, "--for"), Some("3s"));
        assert_eq!(value_of(&arguments, "--run"), None);
    }
}
