//! docs/trade.md: every dial that it names is still there to be turned.

use std::fs;
use std::path::Path;

use super::programs;

const PAGE: &str = include_str!("../../../docs/trade.md");
const TEMPLATE: &str = include_str!("../../../config/template.toml");

/// What stands between backquotes on a line.
fn quoted(line: &str) -> Vec<&str> {
    line.split('`').skip(1).step_by(2).collect()
}

/// Whether the template has a key, commented out or not: `table.key`, where the table may have dots.
fn is_in_template(key: &str) -> bool {
    let (wanted, name) = key.rsplit_once('.').unwrap_or(("", key));
    let mut table = String::new();
    TEMPLATE.lines().any(|line| {
        let line = line.trim_start_matches(['#', ' ']);
        if let Some(header) = line
            .strip_prefix('[')
            .and_then(|l| l.trim_start_matches('[').split_once(']'))
        {
            table = header.0.to_owned();
        }
        let is_key = line
            .strip_prefix(name)
            .is_some_and(|rest| rest.trim_start().starts_with('='));
        table == wanted && is_key
    })
}

/// Whether a command has an option, told as it is typed: the command's words and the option.
fn is_option(typed: &str) -> bool {
    let (words, option) = typed.split_once(" --").unwrap_or((typed, ""));
    let mut words = words.split(' ');
    let program = words.next().unwrap_or_default();
    let Some(mut command) = programs::all().into_iter().find(|c| c.get_name() == program) else {
        return false;
    };
    for word in words {
        match command.find_subcommand(word) {
            Some(below) => command = below.clone(),
            None => return false,
        }
    }
    command.get_arguments().any(|a| a.get_long() == Some(option))
}

/// Whether a file of the repository has a word of its own.
fn is_in_file(word: &str, file: &str) -> bool {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap_or_default();
    text.split(|c: char| !c.is_alphanumeric() && c != '_')
        .any(|w| w == word)
}

/// What is wrong with the line that says where a dial is turned.
fn gone(line: &str) -> Option<String> {
    let is_there = match quoted(line)[..] {
        [key] if line.starts_with("Turned by the scene's") => is_in_template(key),
        [option] if line.starts_with("Turned by") => is_option(option),
        [word, file] => is_in_file(word, file),
        _ => false,
    };
    (!is_there).then(|| line.to_owned())
}

#[test]
fn every_dial_of_the_page_is_there_to_be_turned() {
    let lines: Vec<&str> = PAGE
        .lines()
        .filter(|l| l.starts_with("Turned by") || l.starts_with("No key"))
        .collect();
    assert_eq!(lines.len(), PAGE.lines().filter(|l| l.starts_with("### ")).count());
    assert!(lines.len() > 20, "{}", lines.len());
    let gone: Vec<String> = lines.into_iter().filter_map(gone).collect();
    assert!(gone.is_empty(), "{gone:#?}");
}

#[test]
fn a_dial_that_went_is_found() {
    assert_eq!(gone("Turned by the scene's `tissue.tolerance`."), None);
    assert_eq!(
        gone("Turned by the scene's `tracker.smoothing.time_constant_ms`."),
        None
    );
    assert_eq!(gone("Turned by `calib pivot --method`."), None);
    assert_eq!(
        gone("No key: `order` in `crates/simulation/src/space/cells/settings.rs`."),
        None
    );
    for line in [
        "Turned by the scene's `tissue.precision`.",
        "Turned by the scene's `tracker.tolerance`.",
        "Turned by the scene's `views.filte`.",
        "Turned by `calib pivot --speed`.",
        "Turned by `calib turn --method`.",
        "Turned by `scalpel --method`.",
        "No key: `orders` in `crates/simulation/src/space/cells/settings.rs`.",
        "No key: `order` in `crates/simulation/src/nowhere.rs`.",
        "Turned by hand.",
    ] {
        assert_eq!(gone(line), Some(line.to_owned()));
    }
}
