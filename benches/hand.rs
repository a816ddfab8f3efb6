//! A hand in silico: how long it takes to reach a target, and how near, by the sight and by slices alone, with noise
//! and with lag.
//!
//! `cargo bench --bench hand -- [TASKS] [--out DIR]`: TASKS of each case (1000), one line a task in DIR/hand.csv, four
//! charts in DIR/hand.png. Ends with the sight's numbers against the window's pixels on 200 tasks. What it means:
//! `docs/hand.md`.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(unreachable_pub, reason = "modules of this program, and no crate")]

#[path = "hand/figures.rs"]
mod figures;
#[path = "hand/picture.rs"]
mod picture_of;
#[path = "hand/pixels.rs"]
mod pixels;
#[path = "hand/slices.rs"]
mod slices;
#[path = "hand/study.rs"]
mod study;

use std::path::PathBuf;
use std::process::ExitCode;

use figures::{Figures, HEAD, row};
use study::{Case, Done, compared, csv, main_cases, other_cases};

/// Tasks of each case, and of the comparison with the pixels.
const TASKS: u64 = 1000;
const COMPARED: u64 = 200;

const HELP: &str = "A scripted operator reaches targets by the sight and by slices alone.

    cargo bench --bench hand                        1000 tasks of each case, files in target/hand
    cargo bench --bench hand -- 100                 a tenth of them: a quick look
    cargo bench --bench hand -- 1000 --out DIR      files in DIR: hand.csv (one line a task), hand.png (charts)

The same number of tasks gives the same bytes.
`cargo test -p trocar --bench hand -- 100` does the same without a release build.";

/// What is asked on the command line.
struct Asked {
    tasks: u64,
    out: PathBuf,
}

fn asked(words: impl Iterator<Item = String>) -> Result<Option<Asked>, String> {
    let mut asked = Asked {
        tasks: TASKS,
        out: PathBuf::from("target/hand"),
    };
    // Cargo adds --bench.
    let mut words = words.filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        match word.as_str() {
            "--help" | "-h" => return Ok(None),
            "--out" => asked.out = words.next().ok_or("--out needs a folder")?.into(),
            number => {
                let tasks = number.parse().ok().filter(|tasks| *tasks > 0);
                asked.tasks = tasks.ok_or_else(|| format!("{number}: a number of tasks, --out DIR or --help"))?;
            }
        }
    }
    Ok(Some(asked))
}

fn main() -> ExitCode {
    let asked = match asked(std::env::args().skip(1)) {
        Ok(Some(asked)) => asked,
        Ok(None) => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        Err(why) => {
            println!("{why}\n\n{HELP}");
            return ExitCode::FAILURE;
        }
    };
    std::fs::create_dir_all(&asked.out).unwrap();
    println!("{HEAD}");
    let mut done = run(main_cases(), asked.tasks);
    println!("\nOne thing at a time:\n\n{HEAD}");
    done.extend(run(other_cases(), asked.tasks));
    println!("\n{COMPARED} tasks by the sight's numbers and by the window's pixels:\n\n{HEAD}");
    let pair = run(compared().to_vec(), COMPARED);
    let [sight, pixels] = [&pair[0], &pair[1]].map(|done| Figures::of(&done.outcomes));
    let apart = |a: f64, b: f64| 100.0 * (b / a - 1.0).abs();
    println!(
        "\nmedians apart: time {:.1} %, miss {:.1} %; at most 10 % are allowed",
        apart(sight.time_s.value, pixels.time_s.value),
        apart(sight.miss_mm.value, pixels.miss_mm.value)
    );
    done.extend(pair);
    ratios(&done);
    let [table, charts] = ["hand.csv", "hand.png"].map(|name| asked.out.join(name));
    std::fs::write(&table, csv(&done)).unwrap();
    picture::write_png(&charts, &picture_of::draw(&done), &[]).unwrap();
    println!("\n{}\n{}", table.display(), charts.display());
    ExitCode::SUCCESS
}

/// Each with its row as soon as it is done.
fn run(cases: Vec<Case>, tasks: u64) -> Vec<Done> {
    let run = |case: Case| {
        let done = case.run(tasks);
        println!("{}", row(&done));
        done
    };
    cases.into_iter().map(run).collect()
}

/// How many times longer it takes by slices alone, case by case.
fn ratios(done: &[Done]) {
    println!("\nmedian time by slices over that by the sight:");
    for slices in done.iter().filter(|done| done.case.display == study::Display::Slices) {
        let is_same = |other: &&Done| {
            let (a, b) = (&other.case, &slices.case);
            a.display == study::Display::Sight
                && (&a.variant, a.noise_mm, a.lag_ms) == (&b.variant, b.noise_mm, b.lag_ms)
        };
        // Of glances the sight has none: another length of theirs is held against the plain sight.
        let plain = |other: &&Done| {
            let case = &other.case;
            case.display == study::Display::Sight
                && case.variant.is_empty()
                && case.noise_mm == slices.case.noise_mm
                && case.lag_ms == 0.0
        };
        if let Some(sight) = done.iter().find(is_same).or_else(|| done.iter().find(plain)) {
            let [a, b] = [sight, slices].map(|done| Figures::of(&done.outcomes).time_s.value);
            let case = &slices.case;
            println!(
                "  noise {} mm, lag {} ms {}: {:.2}",
                case.noise_mm,
                case.lag_ms,
                case.variant,
                b / a
            );
        }
    }
}
