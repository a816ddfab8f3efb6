//! A machine with too much to do: what the priorities of a scene are worth.
//!
//! `cargo bench --bench overload -- [SECONDS] [load N]`: navigates in config/demo.toml for SECONDS (20) beside N busy loops (8) of nice
//! value 0, with different `[priorities]`, twice each and in turn, and prints how late images were. Values below 0 need the right to.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/support/load.rs"]
mod load;
#[path = "../tests/support/mod.rs"]
mod support;

use std::path::Path;

use load::Load;
use support::World;

const SETTINGS: [(&str, &str); 5] = [
    ("as shipped", ""),
    ("recorder 10", "[priorities]\nrecorder = 10\n"),
    ("tracker, renderers -5", "[priorities]\ntracker = -5\nrenderers = -5\n"),
    (
        "tracker -15, renderers -10",
        "[priorities]\ntracker = -15\nrenderers = -10\n",
    ),
    ("real_time", "[priorities]\nreal_time = true\n"),
];

fn main() {
    let (_, seconds, load) = load::asked();
    let (seconds, load) = (seconds.unwrap_or(20.0), load.unwrap_or(8));
    let _load = Load::new(load);
    let demo = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("config/demo.toml")).unwrap();
    println!(
        "| beside {load} busy loops | image p50, p95, p99, most, ms | poses dropped by views | missing | problems |"
    );
    println!("|---|---|---|---|---|");
    for (name, priorities) in SETTINGS.iter().chain(&SETTINGS) {
        let world = World::new();
        let scene = world.file("s.toml", &format!("{demo}\n{priorities}"));
        let out = world.path("out");
        let arguments = ["run", "--headless", "--for", &format!("{seconds}s")];
        let mut command = world.command("pilot");
        // A problem of the run is what is measured, and no failure.
        command.args(arguments).arg(&scene).arg("--out").arg(&out);
        command.stdout(std::process::Stdio::null()).status().unwrap();
        let report = support::report(&out);
        let stages = report["latency_ms"].as_object().unwrap();
        let whole = &stages["pose_to_pixels"];
        let age = ["p50", "p95", "p99", "max"].map(|key| format!("{:.1}", whole[key].as_f64().unwrap()));
        let dropped: u64 = report["views"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|v| v["dropped"].as_u64())
            .sum();
        let problems = report["problems"].as_array().map_or(0, Vec::len);
        println!(
            "| {name} | {} | {dropped} | {} | {problems} |",
            age.join(" / "),
            report["poses"]["missing"]
        );
    }
}
