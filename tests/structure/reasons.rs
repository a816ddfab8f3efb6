//! Bodies of the numerics say why: the reader of a formula needs the reason more than the reader of a form.

use std::fs;
use std::path::{Path, PathBuf};

use crate::floors::{root, rust_files};

/// Where numbers are made.
const NUMERIC: &[&str] = &[
    "calib/bead/src",
    "calib/optics/src",
    "calib/src",
    "calib/surface-registration/src",
    "crates/fit/src",
    "crates/geometry/src",
    "crates/simulation/src",
    "crates/surface/src",
    "slice-view-proc/src/reslice",
];
/// Bodies of more lines than this, from the `fn` to its closing brace, hold a sentence of why.
const LONG_LINES: usize = 25;

/// The least share of lines of the numerics that are comments in bodies, per cent: that of the code which this one is measured by is 5.
const LEAST_COMMENTS_PERCENT: f64 = 3.0;

/// The name and the lines of each function of a file: from the line of its `fn` to the closing brace under it. Functions without a body
/// are left out; those of tests are, as what stands behind `mod tests`.
fn functions(text: &str) -> Vec<(String, Vec<&str>)> {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(text);
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (first, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let indent = &line[..line.len() - code.len()];
        let Some(name) = name_of(code) else { continue };
        let opens = lines[first..].iter().position(|l| l.ends_with('{') || l.ends_with(';'));
        if !opens.is_some_and(|k| lines[first + k].ends_with('{')) {
            continue;
        }
        let end = format!("{indent}}}");
        let length = lines[first..].iter().position(|l| *l == end);
        found.extend(length.map(|n| (name.to_owned(), lines[first..=first + n].to_vec())));
    }
    found
}

/// The name of the function that a line begins.
fn name_of(code: &str) -> Option<&str> {
    let rest = code.strip_prefix("pub").map_or(code, |rest| {
        let rest = rest
            .strip_prefix('(')
            .and_then(|rest| rest.split_once(')'))
            .map_or(rest, |(_, rest)| rest);
        rest.trim_start()
    });
    let rest = rest.strip_prefix("const ").unwrap_or(rest);
    let rest = rest.strip_prefix("unsafe ").unwrap_or(rest);
    rest.strip_prefix("fn ")?.split(['(', '<']).next()
}

fn says_why(body: &[&str]) -> bool {
    let is_comment =
        |line: &&str| line.trim_start().starts_with("// ") || line.contains("; // ") || line.contains(", // ");
    body.iter().any(is_comment)
}

/// Long bodies without a reason. What only writes words (`fmt`) needs none.
fn silent(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let long = functions(&text).into_iter().filter(|(_, body)| body.len() > LONG_LINES);
    long.filter(|(name, body)| name != "fmt" && !says_why(body))
        .map(|(name, body)| format!("{}: fn {name}, {} lines", file.display(), body.len()))
        .collect()
}

/// The files where numbers are made, without tests.
fn numeric_files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    NUMERIC
        .iter()
        .for_each(|folder| rust_files(&root().join(folder), &mut files));
    files.retain(|file| !file.ends_with("tests.rs") && !file.components().any(|part| part.as_os_str() == "tests"));
    assert!(files.len() > 250, "found only {}", files.len());
    files
}

/// All lines of a file before its tests, and those of them that are comments of a body.
fn shares(file: &Path) -> [usize; 2] {
    let text = fs::read_to_string(file).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(&text);
    let comments = text.lines().filter(|line| line.trim_start().starts_with("// "));
    [text.lines().count(), comments.count()]
}

#[test]
fn bodies_of_the_numerics_have_their_share_of_reasons() {
    for folder in NUMERIC {
        let files = numeric_files()
            .into_iter()
            .filter(|file| file.starts_with(root().join(folder)));
        let [lines, comments] = files
            .map(|file| shares(&file))
            .fold([0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        println!(
            "{folder}: {comments} comments in {lines} lines, {:.2} %",
            100.0 * comments as f64 / lines as f64
        );
    }
    let all = numeric_files()
        .iter()
        .map(|file| shares(file))
        .fold([0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let percent = 100.0 * all[1] as f64 / all[0] as f64;
    assert!(
        percent >= LEAST_COMMENTS_PERCENT,
        "{} comments in {} lines: {percent:.2} %",
        all[1],
        all[0]
    );
}

#[test]
fn long_bodies_of_the_numerics_say_why() {
    let files = numeric_files();
    let silent: Vec<String> = files.iter().flat_map(|file| silent(file)).collect();
    assert!(silent.is_empty(), "no line of why in:\n{}", silent.join("\n"));
}

#[test]
fn functions_are_read_with_their_bodies() {
    let long = "    let x = 1;\n".repeat(LONG_LINES);
    let text = format!(
        "fn a();\npub(super) const fn b(\n    x: u8,\n) -> u8 {{\n{long}}}\nfn c<T>() {{\n    // Why.\n{long}}}\n"
    );
    let found = functions(&text);
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["b", "c"]);
    assert_eq!(found[0].1.len(), LONG_LINES + 4);
    assert!(!says_why(&found[0].1) && says_why(&found[1].1));
}
