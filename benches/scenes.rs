//! What each shipped scene costs: `cargo bench --bench scenes -- [SECONDS]` runs each for SECONDS (10) and prints the table of
//! docs/scenes.md: its processes with their threads, memory and processor time.
//!
//! Memory is what a process holds beside the volume, which all share: its proportional share (PSS) less that of the volume.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/support/mod.rs"]
mod support;

use std::fs;
use std::path::Path;
use std::time::Duration;

use support::World;

/// The shipped scenes that make their poses themselves.
const SCENES: [&str; 5] = ["demo", "one-view", "operating-room", "operating-room-stress", "surface"];
/// Ticks of processor time a second, as Linux counts them for programs on every machine.
const TICKS_PER_S: f64 = 100.0;

fn main() {
    let asked = std::env::args()
        .skip(1)
        .find_map(|argument| argument.parse::<f64>().ok());
    let seconds = asked.unwrap_or(10.0);
    println!("| scene | process | threads | memory, MiB | processor, % of one |");
    println!("|---|---|---|---|---|");
    for scene in SCENES {
        let world = World::new();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("config/{scene}.toml"));
        let pilot = world.start(&path, &world.path("out"), "default");
        let status = pilot.wait_for("every process ready", |status| {
            let processes = status["processes"].as_array().unwrap();
            !processes.is_empty() && processes.iter().all(|process| process["stage"] == "ready")
        });
        let processes = status["processes"].as_array().unwrap().iter();
        let named = processes.map(|p| (p["name"].as_str().unwrap().to_owned(), p["pid"].as_u64().unwrap()));
        let mut all = vec![("pilot".to_owned(), u64::from(pilot.child.id()))];
        all.extend(named);
        let before: Vec<f64> = all.iter().map(|(_, pid)| processor_s(*pid)).collect();
        std::thread::sleep(Duration::from_secs_f64(seconds));
        let loader = all.iter().find(|(name, _)| name == "volume-loader").unwrap().1;
        let segment = volume_of(loader);
        let mut volume_mib = 0.0;
        for ((name, pid), before) in all.iter().zip(before) {
            let share = 100.0 * (processor_s(*pid) - before) / seconds;
            let (own, volume) = memory_mib(*pid, &segment);
            volume_mib += volume;
            println!("| {scene} | {name} | {} | {own:.1} | {share:.1} |", threads(*pid));
        }
        println!("| {scene} | the volume, once for all | | {volume_mib:.1} | |");
        pilot.stop();
    }
}

/// User and system time so far.
fn processor_s(pid: u64) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    // Behind the name, which may hold anything: state is field 3, the times are 14 and 15.
    let fields: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
    let ticks = |field: usize| fields[field - 3].parse::<f64>().unwrap();
    (ticks(14) + ticks(15)) / TICKS_PER_S
}

fn threads(pid: u64) -> usize {
    fs::read_dir(format!("/proc/{pid}/task")).unwrap().count()
}

/// Proportional shares, MiB: all but the volume, and the volume.
fn memory_mib(pid: u64, volume: &str) -> (f64, f64) {
    let (mut own, mut shared) = (0.0, 0.0);
    for (path, _, pss_mib) in mappings(pid) {
        *(if path == volume { &mut shared } else { &mut own }) += pss_mib;
    }
    (own, shared)
}

/// The loader's largest mapping of shared memory.
fn volume_of(loader: u64) -> String {
    let all = mappings(loader)
        .into_iter()
        .filter(|(path, ..)| path.starts_with("/dev/shm/"));
    all.max_by_key(|(_, bytes, _)| *bytes).unwrap().0
}

/// Path, length and proportional share of each mapping.
fn mappings(pid: u64) -> Vec<(String, u64, f64)> {
    let text = fs::read_to_string(format!("/proc/{pid}/smaps")).unwrap();
    let mut all: Vec<(String, u64, f64)> = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["Pss:", kib, "kB"] => {
                if let Some(last) = all.last_mut() {
                    last.2 = kib.parse::<f64>().unwrap() / 1024.0;
                }
            }
            [range, _, _, _, _, ..] if range.contains('-') => {
                let ends: Vec<u64> = range
                    .split('-')
                    .map(|end| u64::from_str_radix(end, 16).unwrap())
                    .collect();
                all.push((words.get(5).unwrap_or(&"").to_string(), ends[1] - ends[0], 0.0));
            }
            _ => {}
        }
    }
    all
}
