//! The demonstration.

use std::os::unix::net::UnixStream;
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
    let display = std::env::var("DISPLAY").unwrap_or_default();
    let has_display = display_socket(&display).is_some_and(|path| UnixStream::connect(path).is_ok());
    let arguments = arguments(extra, &root().join("out").to_string_lossy(), has_display);
    let mut pilot = program(target().join("release/pilot"), &[]);
    let navigated = run(pilot.args(&arguments).current_dir(here()));
    if let Some(out) = value_of(&arguments, "--out") {
        point_at(&here().join(out));
    }
    navigated
}

/// `pilot run` with the demonstration's defaults where `extra` says nothing else. A session in a folder that the user
/// named is not overwritten.
fn arguments(extra: &[String], out: &str, has_display: bool) -> Vec<String> {
    let mut all: Vec<&str> = vec!["run"];
    let says = |flag: &str| value_of(extra, flag).is_some() || extra.iter().any(|a| a == flag);
    if !says("--headless") && !says("--window") {
        // Where there is a display the demonstration is to be seen; it goes on without where there is none.
        all.push(if has_display { "--window" } else { "--headless" });
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

/// Where the display of this machine that `DISPLAY` names listens; `None` for one of another machine, and for none.
fn display_socket(display: &str) -> Option<String> {
    let number = display.strip_prefix(':')?.split('.').next()?;
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| format!("/tmp/.X11-unix/X{number}"))
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
        arguments(&extra, "o", false).join(" ")
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
    fn a_window_opens_where_there_is_a_display_and_nobody_says_otherwise() {
        let words = |extra: &[&str]| {
            let extra: Vec<String> = extra.iter().map(ToString::to_string).collect();
            arguments(&extra, "o", true).join(" ")
        };
        assert_eq!(words(&["--for=3s"]), "run --window --out o --overwrite --for=3s");
        assert_eq!(
            words(&["--for=3s", "--headless"]),
            "run --out o --overwrite --for=3s --headless"
        );
        assert_eq!(display_socket(":12.0").as_deref(), Some("/tmp/.X11-unix/X12"));
        for none in ["", "host:0", ":", ":../x", "12"] {
            assert_eq!(display_socket(none), None, "{none}");
        }
    }

    #[test]
    fn values_are_found_in_both_forms() {
        let arguments = ["--out".to_owned(), "a".to_owned(), "--for=3s".to_owned()];
        assert_eq!(value_of(&arguments, "--out"), Some("a"));
        assert_eq!(value_of(&arguments, "--for"), Some("3s"));
        assert_eq!(value_of(&arguments, "--run"), None);
    }
}
