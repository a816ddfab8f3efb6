//! A long run: whether memory, files and latencies stay as they are.
//!
//! `cargo bench --bench soak -- [MINUTES] [kill SECONDS] [tissue]` (120 minutes): navigates in config/demo.toml with a recording, looks every
//! ten seconds, and fits a line to what is seen after the first tenth of the time. With `kill`, one process dies every so many seconds, each
//! in its turn. With `tissue` the scene is config/tissue.toml, whose tube strokes organs all the time. Ends with 1 where something grows: by
//! more than three errors of its slope, and by more than it may in a day; or where an image did not say what it shows of the organ.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "the table is what this program is for"
)]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::disallowed_methods, reason = "durations for people, which never reach a bus")]

#[path = "../tests/support/mod.rs"]
mod support;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use bus::run::{RunContext, SHM_DIR};
use serde_json::Value;
use support::{Pilot, World, kill_9, pid_in};

const EVERY: Duration = Duration::from_secs(10);

/// What is seen, by name: hours since the start, and the value.
type Seen = BTreeMap<String, Vec<[f64; 2]>>;

/// A line through what is seen.
struct Line {
    first: f64,
    last: f64,
    per_hour: f64,
    /// The slope's standard error, from what the line leaves.
    error: f64,
}

impl Line {
    /// Least squares; none through fewer than ten values.
    fn through(values: &[[f64; 2]]) -> Option<Self> {
        let n = values.len() as f64;
        let mean = |k: usize| values.iter().map(|v| v[k]).sum::<f64>() / n;
        let (x, y) = (mean(0), mean(1));
        let sxx: f64 = values.iter().map(|v| (v[0] - x).powi(2)).sum();
        let per_hour = values.iter().map(|v| (v[0] - x) * (v[1] - y)).sum::<f64>() / sxx;
        let left = values
            .iter()
            .map(|v| (v[1] - y - per_hour * (v[0] - x)).powi(2))
            .sum::<f64>();
        (values.len() >= 10).then(|| Self {
            first: values[0][1],
            last: values[values.len() - 1][1],
            per_hour,
            error: (left / (n - 2.0) / sxx).sqrt(),
        })
    }

    /// Whether it goes up beyond doubt, by more than `per_day`.
    fn grows(&self, per_day: f64) -> bool {
        self.per_hour > 3.0 * self.error && 24.0 * self.per_hour > per_day
    }
}

/// The memory of a process, its share of what several map included, MiB.
fn memory_mib(pid: u64) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("Pss:"))?;
    Some(line.split_whitespace().next()?.parse::<f64>().ok()? / 1024.0)
}

fn entries(folder: &Path) -> usize {
    let Ok(read) = std::fs::read_dir(folder) else { return 0 };
    read.flatten()
        .map(|entry| {
            if entry.path().is_dir() {
                1 + entries(&entry.path())
            } else {
                1
            }
        })
        .sum()
}

/// What the run has in shared memory; other runs of the machine have files there too.
fn shared_files(run: &RunContext) -> usize {
    let prefix = run.folder_prefix();
    let read = std::fs::read_dir(SHM_DIR).unwrap().flatten();
    read.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix))
        .count()
}

/// Looks once.
fn look(pilot: &Pilot<'_>, world: &World, hours: f64, seen: &mut Seen) {
    let mut put = |name: String, value: f64| seen.entry(name).or_default().push([hours, value]);
    let Some(status) = pilot.status() else { return };
    let processes = status["processes"].as_array().unwrap();
    let named = processes
        .iter()
        .filter_map(|p| Some((p["name"].as_str()?, p["pid"].as_u64()?)));
    for (name, pid) in named.chain([("pilot", u64::from(pilot.child.id()))]) {
        if let Some(mib) = memory_mib(pid) {
            put(format!("{name}: memory, MiB"), mib);
            put(
                format!("{name}: open files"),
                entries(Path::new(&format!("/proc/{pid}/fd"))) as f64,
            );
        }
    }
    put("files of the run".to_owned(), entries(&world.run_dir("soak")) as f64);
    if let Ok(run) = RunContext::load(&world.run_dir("soak")) {
        put("files in shared memory".to_owned(), shared_files(&run) as f64);
    }
    put(
        "dead processes left".to_owned(),
        status["dead_processes_left"].as_f64().unwrap(),
    );
    let ages: Vec<f64> = status["views"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|v| v["age_ms"].as_f64())
        .collect();
    if !ages.is_empty() {
        put(
            "age of the images, ms".to_owned(),
            ages.iter().sum::<f64>() / ages.len() as f64,
        );
    }
}

/// What a quantity may grow by in a day: less than that is no danger to an operation. The recorder keeps the index of its file, 512
/// bytes a chunk at most, until the file ends: config/demo.toml closes two chunks a second.
fn may_grow(name: &str) -> f64 {
    const CHUNKS_A_DAY: f64 = 2.0 * 86_400.0;
    match name {
        "recorder: memory, MiB" => 20.0 + CHUNKS_A_DAY * 512.0 / f64::from(1 << 20),
        name if name.ends_with("MiB") => 20.0,
        name if name.ends_with("ms") => 5.0,
        _ => 5.0,
    }
}

fn kill(status: &Value, turn: usize) {
    let names: Vec<&str> = status["processes"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|p| p["name"].as_str())
        .collect();
    if let Some(pid) = pid_in(status, names[turn % names.len()]) {
        kill_9(pid);
    }
}

/// The text of the scene: in a folder of its own, so that what it names beside it has its whole path.
fn scene(moves_organs: bool) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |name: &str| std::fs::read_to_string(root.join("config").join(name)).unwrap();
    if !moves_organs {
        return read("demo.toml");
    }
    let organs = root.join("config/solids/demo-organs.toml");
    let changed = [
        ("solids/demo-organs.toml", organs.to_str().unwrap()),
        // Hardly ever still: in and out all the time.
        ("pause_s = 3.0", "pause_s = 0.5"),
    ];
    changed.iter().fold(read("tissue.toml"), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

/// What the command line asks for.
struct Wanted {
    minutes: f64,
    /// Seconds from one death to the next.
    kills: Option<f64>,
    moves_organs: bool,
}

impl Wanted {
    /// `None` of words that are none: a run of hours is not begun on a guess.
    fn of(words: &[String]) -> Option<Self> {
        let number = |word: &str| word.parse().ok().filter(|n: &f64| *n > 0.0 && n.is_finite());
        let mut wanted = Self {
            minutes: 120.0,
            kills: None,
            moves_organs: false,
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match word.as_str() {
                "kill" => wanted.kills = Some(number(words.next()?)?),
                "tissue" => wanted.moves_organs = true,
                minutes => wanted.minutes = number(minutes)?,
            }
        }
        Some(wanted)
    }
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let Some(wanted) = Wanted::of(&words) else {
        eprintln!("soak: found {words:?}; [MINUTES] [kill SECONDS] [tissue] is allowed");
        return ExitCode::from(2);
    };
    let Wanted {
        minutes,
        kills,
        moves_organs,
    } = wanted;
    let world = World::new();
    let demo = scene(moves_organs);
    let scene = match kills {
        // As many deaths as this are a loop, and held, by the usual limits.
        Some(_) => demo.replace("[limits]", "[limits]\nrestarts = 100\nrestart_window_s = 1.0"),
        None => demo,
    };
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "soak");
    pilot.wait_live();
    let (began, mut seen, mut turn) = (Instant::now(), Seen::new(), 0);
    while began.elapsed().as_secs_f64() < 60.0 * minutes {
        std::thread::sleep(EVERY);
        look(&pilot, &world, began.elapsed().as_secs_f64() / 3600.0, &mut seen);
        if kills.is_some_and(|seconds| began.elapsed().as_secs_f64() > seconds * (turn + 1) as f64) {
            kill(&pilot.wait_live(), turn);
            turn += 1;
            pilot.wait_live();
        }
    }
    let code = pilot.stop().code();
    let report = support::report(&world.path("out"));
    let (problems, tissue) = (&report["problems"], &report["tissue"]);
    println!("{minutes} min, {turn} processes killed, exit code {code:?}, problems {problems}");
    let is_marked = tissue.is_null() || tissue["unmarked"] == 0;
    if !tissue.is_null() {
        println!("images by what they show of the organ: {tissue}");
    }
    println!("| | first | last | per hour |\n|---|---|---|---|");
    let mut all_flat = true;
    for (name, values) in &seen {
        let settled = values[values.len() / 10..].to_vec();
        let Some(line) = Line::through(&settled) else { continue };
        let grows = line.grows(may_grow(name));
        all_flat &= !grows;
        println!(
            "| {name} | {:.2} | {:.2} | {:.3} ± {:.3}{} |",
            line.first,
            line.last,
            line.per_hour,
            line.error,
            if grows { " GROWS" } else { "" }
        );
    }
    if all_flat && is_marked {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
