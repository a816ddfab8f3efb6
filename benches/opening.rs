//! How long it takes from `pilot replay FILE` to the first image, of a large recording and of a small one.
//!
//! `cargo bench --bench opening -- [COUNT] [MEGABYTES] [load N]`: makes recordings of MEGABYTES (1000) and of 1 MB, of the same poses at
//! 60 Hz, and opens each COUNT times (10) in turn, beside N busy loops (0): as the memory has it, and as the disk has it (its pages
//! dropped from the memory before). Prints the medians of the parts and the largest whole, and how long it takes to read all of the
//! large one (`recorder facts --whole`). The examination is the generated patient at 6 mm, with three small images: loading is nearly
//! nothing of it. With Xvfb, the large one again with the operator's window.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(unreachable_pub, reason = "a module of this program, and not a crate")]

#[allow(dead_code, reason = "no eye looks at the screen here")]
#[path = "../tests/support/display.rs"]
mod display;
#[path = "opening/file.rs"]
mod file;
#[path = "../tests/support/load.rs"]
mod load;
#[path = "../tests/support/mod.rs"]
mod support;

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{FrameStamp, FrameState, Heartbeat, ProcessState, ToolPose};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::{FRAME_STAMP, HEARTBEAT, TOOL_POSE};
use display::Display;
use load::Load;
use rustix::fs::{Advice, fadvise};
use scene::Plane;
use support::{Pilot, SMALL, World, wait_for};

/// Between two looks.
const LOOK: Duration = Duration::from_micros(500);
/// The small recording.
const SMALL_BYTES: u64 = 1_000_000;

/// When what had come, ms behind the start of `pilot replay`.
#[derive(Clone, Copy)]
struct Opened {
    /// The recorder's word on the recording alone, in a process of its own, as the pilot asks for it.
    facts: f64,
    /// The run's folder: the pilot has asked the recorder for what it must know.
    known: f64,
    /// The replayer has the recording open.
    ready: f64,
    /// The first pose on the bus.
    pose: f64,
    /// The first image of it.
    image: f64,
}

fn main() {
    let (words, count, load) = load::asked();
    let (count, load) = (count.unwrap_or(10.0) as usize, load.unwrap_or(0));
    let megabytes = words.get(1).and_then(|n| n.parse().ok()).unwrap_or(1000);
    let world = World::new();
    let scene = world.file("scene.toml", SMALL);
    let (large, small) = (world.path("large"), world.path("small"));
    for folder in [&large, &small] {
        fs::create_dir(folder).unwrap();
    }
    let large = file::make(&large, "s.mcap", &scene, megabytes * 1_000_000);
    let small = file::make(&small, "s.mcap", &scene, SMALL_BYTES);
    let _load = Load::new(load);
    println!("beside {load} busy loops, {count} times each; ms from the start of `pilot replay` to");
    println!(
        "| recording | `recorder facts` alone | run begun | replayer ready | first pose | first image | largest |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut rows = [const { Vec::new() }; 4];
    for _ in 0..count {
        for (k, recording) in [&small, &large].into_iter().enumerate() {
            rows[k].push(opened(&world, recording, false, None));
            rows[k + 2].push(opened(&world, recording, true, None));
        }
    }
    let length = fs::metadata(&large).unwrap().len() as f64 / 1e6;
    let names = [
        "1 MB",
        &format!("{length:.0} MB"),
        "1 MB, from the disk",
        &format!("{length:.0} MB, from the disk"),
    ];
    let images: Vec<f64> = names.iter().zip(&rows).map(|(name, row)| told(name, row)).collect();
    if let Some(display) = Display::new([1920, 1080]) {
        let row: Vec<Opened> = (0..count)
            .map(|_| opened(&world, &large, false, Some(&display.name)))
            .collect();
        told(&format!("{length:.0} MB, with the window"), &row);
    }
    let began_ns = monotonic_ns();
    let output = world.output("recorder", &["facts", "--whole", &large.to_string_lossy()]);
    assert!(output.status.success());
    let whole = ms_since(began_ns);
    let [small_ms, large_ms] = [images[0], images[1]];
    println!(
        "the first image of the large recording takes {:.2} times that of the small one; reading all of it takes {whole:.0} ms, {:.0} times",
        large_ms / small_ms,
        whole / large_ms
    );
}

/// Prints the medians of a row; returns that of the first image.
fn told(name: &str, row: &[Opened]) -> f64 {
    let median = |of: fn(&Opened) -> f64| {
        let mut values: Vec<f64> = row.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        (values[values.len() / 2], values[values.len() - 1])
    };
    let parts: [fn(&Opened) -> f64; 4] = [|o| o.facts, |o| o.known, |o| o.ready, |o| o.pose];
    let parts: Vec<String> = parts.iter().map(|of| format!("{:.0}", median(*of).0)).collect();
    let (image, largest) = median(|o| o.image);
    println!("| {name} | {} | {image:.0} | {largest:.0} |", parts.join(" | "));
    image
}

fn ms_since(began_ns: i64) -> f64 {
    (monotonic_ns() - began_ns) as f64 / 1e6
}

/// Opens a recording once.
fn opened(world: &World, recording: &Path, from_disk: bool, display: Option<&str>) -> Opened {
    let forget = || {
        if from_disk {
            let file = fs::File::open(recording).unwrap();
            fadvise(&file, 0, None, Advice::DontNeed).unwrap();
        }
    };
    forget();
    let began_ns = monotonic_ns();
    let output = world.output("recorder", &["facts", &recording.to_string_lossy()]);
    let facts = ms_since(began_ns);
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        support::stderr(&output)
    );
    forget();
    let mut command = world.command("pilot");
    command
        .args(["replay", "--force", "--run", "replay", "--speed", "1", "--out"])
        .args([&world.path("out"), recording])
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    match display {
        Some(name) => command.arg("--window").env("DISPLAY", name),
        None => command.arg("--headless"),
    };
    let began_ns = monotonic_ns();
    let pilot = Pilot::of(world, "replay", command.spawn().unwrap());
    let opened = Opened {
        facts,
        ..watched(&world.run_dir("replay"), began_ns)
    };
    pilot.stop();
    opened
}

/// Waits for the parts of an opening, but for what the recorder says alone.
fn watched(run_dir: &Path, began_ns: i64) -> Opened {
    let looked = |what: &str, is_there: &mut dyn FnMut() -> bool| {
        wait_for(what, || {
            let until_ns = monotonic_ns() + 1_000_000_000;
            while monotonic_ns() < until_ns {
                if is_there() {
                    return Some(ms_since(began_ns));
                }
                std::thread::sleep(LOOK);
            }
            None
        })
    };
    let mut joined = None;
    let known = looked("a run", &mut || {
        joined = RunContext::load(run_dir).ok();
        joined.is_some()
    });
    let bus = Bus::join(&joined.unwrap()).unwrap();
    let beats: Subscriber<Heartbeat> = Subscriber::open(&bus, &HEARTBEAT, "replay", 1).unwrap();
    let poses: Subscriber<ToolPose> = Subscriber::open(&bus, &TOOL_POSE, "", TOOL_POSE.buffer).unwrap();
    let planes = [Plane::Axial, Plane::Frontal, Plane::Perpendicular];
    let stamps = planes.map(|plane| Subscriber::<FrameStamp>::open(&bus, &FRAME_STAMP, &plane.process(), 1).unwrap());
    let (mut ready, mut pose) = (None, None);
    let image = looked("an image", &mut || {
        let now = Some(ms_since(began_ns));
        let beat = beats.newest().unwrap();
        if beat.is_some_and(|beat| beat.process_state() == ProcessState::Ready) {
            ready = ready.or(now);
        }
        if poses.newest().unwrap().is_some() {
            pose = pose.or(now);
        }
        let is_live = |stamp: FrameStamp| stamp.frame_state() == Some(FrameState::Live);
        stamps
            .iter()
            .any(|stamps| stamps.newest().unwrap().is_some_and(is_live))
    });
    Opened {
        facts: 0.0,
        known,
        ready: ready.unwrap_or(image),
        pose: pose.unwrap_or(image),
        image,
    }
}
