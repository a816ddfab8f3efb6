//! From a pose's capture to its pixels on the glass, and from a killed window to the next.
//!
//! `cargo bench --bench glass -- [SECONDS] [load N]`: navigates in config/demo.toml with the operator's window on an X server in memory of
//! 1920 x 1080, beside N busy loops (0). Reads the coded cell back off the screen every 5 ms, for SECONDS (20), three times: of each
//! new picture the age of its oldest pose when its pixels had come back, and how many pictures there were. Then kills the window 100
//! times and waits for a live picture of the next. Needs Xvfb.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(unreachable_pub, reason = "a module of this program, and not a crate")]

#[path = "../tests/support/display.rs"]
mod display;
#[path = "../tests/support/load.rs"]
mod load;
#[path = "../tests/support/mod.rs"]
mod support;

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use bus::Bus;
use bus::run::RunContext;
use display::Display;
use load::Load;
use support::{Pilot, World, kill_9, wait_for};
use window::code::Shown;

/// Between two looks: one that never rests takes one of two cores from what it looks at.
const LOOK: Duration = Duration::from_millis(5);
/// How often the window is killed.
const KILLS: usize = 100;
/// Between one kill and the next: behind the time in which the supervisor counts them.
const PAUSE: Duration = Duration::from_millis(1500);

fn main() {
    let (_, seconds, load) = load::asked();
    let (seconds, load) = (seconds.unwrap_or(20.0), load.unwrap_or(0));
    let Some(display) = Display::new([1920, 1080]) else {
        return;
    };
    let world = World::new();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/demo.toml");
    // Killed more often than a scene usually allows, and each time as if for the first: at once started again.
    let text = std::fs::read_to_string(demo)
        .unwrap()
        .replace("[limits]", "[limits]\nrestarts = 100\nrestart_window_s = 1.0");
    let scene = world.file("demo.toml", &text);
    let mut command = world.command("pilot");
    command
        .env("DISPLAY", &display.name)
        .args(["run", "--window", "--run", "default", "--out"]);
    command
        .arg(world.path("out"))
        .arg(scene)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let pilot = Pilot::of(&world, "default", command.spawn().unwrap());
    pilot.wait_live();
    let run = RunContext::load(&world.run_dir("default")).unwrap();
    let bus = Bus::join(&run).unwrap();
    let _load = Load::new(load);
    println!(
        "| beside {load} busy loops: pictures a second | live, of these | age of the oldest pose, ms, p50 / p99 / largest |"
    );
    println!("|---|---|---|");
    for _ in 0..3 {
        println!("{}", watched(&display, &run, &bus, seconds));
    }
    println!("{}", killed(&display, &run, &bus, &pilot));
    pilot.stop();
}

/// Watches the screen for so long.
fn watched(display: &Display, run: &RunContext, bus: &Bus, seconds: f64) -> String {
    let began_ns = bus.clock().now_ns();
    let until_ns = began_ns + bus::clock::seconds(seconds);
    let (mut last, mut ages, mut pictures) = (None, Vec::new(), 0_u32);
    let place = wait_for("a window", || display.place());
    while bus.clock().now_ns() < until_ns {
        std::thread::sleep(LOOK);
        let Some((code, _)) = display.code_at(place, run).filter(|(code, _)| last != Some(code.seq())) else {
            continue;
        };
        last = Some(code.seq());
        pictures += 1;
        // After the pixels came back: what a camera in front of the screen would find, at the latest.
        if code.shown() == Shown::Live {
            ages.push(code.age_ms(bus.clock().now_ns()));
        }
    }
    let took_s = bus::clock::ms(bus.clock().now_ns() - began_ns) / 1000.0;
    let part = ages.len() as f64 / f64::from(pictures.max(1));
    let [p50, p99, largest] = quantiles(&mut ages);
    format!(
        "| {:.1} | {:.1} % | {p50} / {p99} / {largest} |",
        f64::from(pictures) / took_s,
        100.0 * part
    )
}

/// Kills the window again and again.
fn killed(display: &Display, run: &RunContext, bus: &Bus, pilot: &Pilot<'_>) -> String {
    let mut took_ms: Vec<i64> = (0..KILLS)
        .map(|_| {
            std::thread::sleep(PAUSE);
            let (_, pid) = wait_for("a live picture", || {
                display.code(run).filter(|(code, _)| code.shown() == Shown::Live)
            });
            assert_eq!(pilot.pid("window"), Some(u64::from(pid)));
            let killed_ns = bus.clock().now_ns();
            kill_9(u64::from(pid));
            loop {
                std::thread::sleep(LOOK);
                let next = display
                    .code(run)
                    .filter(|(code, by)| *by != pid && code.shown() == Shown::Live);
                if next.is_some() {
                    return (bus.clock().now_ns() - killed_ns) / 1_000_000;
                }
            }
        })
        .collect();
    let [p50, _, largest] = quantiles(&mut took_ms);
    format!(
        "from kill -9 of the window to a live picture of the next, {KILLS} times: median {p50}, largest {largest} ms"
    )
}

/// The median, the 99th of a hundred, and the largest.
fn quantiles(values: &mut [i64]) -> [i64; 3] {
    values.sort_unstable();
    let at = |part: f64| {
        let place = (part * values.len() as f64).ceil() as usize;
        values.get(place.saturating_sub(1)).copied().unwrap_or(-1)
    };
    [at(0.5), at(0.99), at(1.0)]
}
