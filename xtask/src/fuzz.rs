//! libFuzzer in front of every parser of what comes from outside.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::failure::Failure;
use crate::shell::{cargo, program, root, run, said, say, target};

/// Seconds for each target where none are given.
const SECONDS: u32 = 60;
/// What `cargo fuzz` hands to the compiler, but for the address sanitizer: it needs a nightly compiler, and the parsers hold no
/// unsafe code.
const FLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
                     -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing";

/// What is looked at, and for how long.
#[derive(Debug, PartialEq)]
struct Asked {
    seconds: u32,
    targets: Vec<String>,
}

fn asked(arguments: &[String]) -> Result<Asked, Failure> {
    let (numbers, targets): (Vec<_>, Vec<_>) = arguments.iter().partition(|a| a.parse::<u32>().is_ok());
    match numbers.as_slice() {
        [] | [_] => Ok(Asked {
            seconds: numbers.first().and_then(|n| n.parse().ok()).unwrap_or(SECONDS),
            targets: targets.into_iter().cloned().collect(),
        }),
        more => Err(Failure::Usage(format!(
            "found {} numbers of seconds, expected one",
            more.len()
        ))),
    }
}

/// Builds the targets, writes their seeds and runs each for some seconds; ARGUMENTS: seconds and names of targets.
///
/// # Errors
/// [`Failure::Step`], [`Failure::Usage`], and [`Failure::Fuzz`] with the inputs that failed.
pub(crate) fn fuzz(arguments: &[String]) -> Result<(), Failure> {
    let asked = asked(arguments)?;
    let (corpus, artifacts, build) = (
        root().join("fuzz/corpus"),
        root().join("fuzz/artifacts"),
        target().join("fuzz"),
    );
    run(cargo(&[
        "run",
        "--quiet",
        "--release",
        "-p",
        "trocar-fuzz",
        "--bin",
        "seeds",
        "--",
    ])
    .arg(&corpus))?;
    let names = names(&corpus, &asked.targets)?;
    let host = host()?;
    run(cargo(&[
        "build",
        "--release",
        "--manifest-path",
        "fuzz/libfuzzer/Cargo.toml",
        "--target",
        &host,
        "--target-dir",
    ])
    .arg(&build)
    .env("RUSTFLAGS", FLAGS))?;
    let exe = build.join(&host).join("release/parse");
    say(&format!(
        "{:10} {:>10} {:>10}  {} s each",
        "target", "inputs", "peak MiB", asked.seconds
    ));
    let mut failed = Vec::new();
    for name in &names {
        failed.extend(one(&exe, name, asked.seconds, [&corpus, &artifacts, &build])?);
    }
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::Fuzz(failed)),
    }
}

/// The targets asked for, or all that have seeds.
fn names(corpus: &Path, asked: &[String]) -> Result<Vec<String>, Failure> {
    let read = |source| Failure::File {
        path: corpus.to_owned(),
        source,
    };
    let mut all = Vec::new();
    for entry in fs::read_dir(corpus).map_err(read)? {
        all.push(entry.map_err(read)?.file_name().to_string_lossy().into_owned());
    }
    all.sort();
    if let Some(wrong) = asked.iter().find(|a| !all.contains(a)) {
        let known = all.join(", ");
        return Err(Failure::Usage(format!(
            "there is no target {wrong:?}; known are {known}"
        )));
    }
    Ok(if asked.is_empty() { all } else { asked.to_vec() })
}

/// The triple of this machine.
fn host() -> Result<String, Failure> {
    let version = said(&mut program("rustc", &["-vV"]))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned)
        .ok_or_else(|| Failure::Usage("rustc -vV names no host".to_owned()))
}

/// Runs a target; the inputs that failed.
fn one(
    exe: &Path,
    name: &str,
    seconds: u32,
    [corpus, artifacts, build]: [&PathBuf; 3],
) -> Result<Vec<PathBuf>, Failure> {
    let folder = artifacts.join(name);
    let file = |path: &Path, source| Failure::File {
        path: path.to_owned(),
        source,
    };
    fs::create_dir_all(&folder).map_err(|e| file(&folder, e))?;
    let log = build.join(format!("{name}.log"));
    let output = File::create(&log).map_err(|e| file(&log, e))?;
    let mut command = program(
        exe,
        &[
            "-max_len=65536",
            "-timeout=10",
            "-rss_limit_mb=2048",
            "-malloc_limit_mb=1024",
        ],
    );
    command
        .args(["-print_final_stats=1".to_owned(), format!("-max_total_time={seconds}")])
        .arg(format!("-artifact_prefix={}/", folder.display()))
        .arg(corpus.join(name))
        .env("TROCAR_FUZZ", name)
        .stdout(Stdio::null())
        .stderr(output);
    let ended = run(&mut command);
    let text = fs::read(&log).map_err(|e| file(&log, e))?;
    let text = String::from_utf8_lossy(&text);
    let stat = |what: &str| {
        let line = text
            .lines()
            .rev()
            .find_map(|line| line.strip_prefix("stat::")?.strip_prefix(what));
        line.map_or("?", |rest| rest.trim_start_matches(':').trim()).to_owned()
    };
    let (inputs, peak) = (stat("number_of_executed_units"), stat("peak_rss_mb"));
    let told = if ended.is_ok() {
        String::new()
    } else {
        format!("FAILED, see {}", log.display())
    };
    say(&format!("{name:10} {inputs:>10} {peak:>10}  {told}"));
    Ok(if ended.is_ok() { Vec::new() } else { vec![folder] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_and_targets_come_in_any_order() {
        let of = |words: &[&str]| asked(&words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>());
        let expected = |seconds, targets: &[&str]| Asked {
            seconds,
            targets: targets.iter().map(|t| (*t).to_owned()).collect(),
        };
        assert_eq!(of(&[]).unwrap(), expected(60, &[]));
        assert_eq!(of(&["mcap", "5", "rom"]).unwrap(), expected(5, &["mcap", "rom"]));
        assert!(of(&["5", "6"]).is_err());
    }
}
