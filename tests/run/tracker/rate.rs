//! How many poses a second the chain can make, and what that costs: a measurement, run by hand on a quiet machine.
//!
//!     cargo test --release --test run tracker_rate -- --ignored --nocapture

#![allow(clippy::print_stdout, reason = "the figures")]

use std::fs;

use crate::support::{World, wait_for};
use bus::Bus;
use bus::clock;
use bus::message::{Heartbeat, ToolPose};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::{HEARTBEAT, TOOL_POSE};

/// One small view, so that the machine is the tracker's.
const SCENE: &str = "seed = 1\n[volume]\nspacing_mm = 6.0\n[tracker]\nsource = \"operating-room\"\nrate_hz = 4000.0\n\
                     [tracker.room.localizer]\nlate_ms = 0.0\n[tracker.room.reference]\n\
                     [[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\nsize = [64, 64]\n";

/// Processor time of a process so far, s.
fn cpu_s(pid: u64) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    // User and system time, in ticks of 10 ms.
    fields[11..13].iter().map(|n| n.parse::<f64>().unwrap()).sum::<f64>() / 100.0
}

#[test]
#[ignore = "a measurement of 10 s that needs a quiet machine"]
fn poses_at_4000_hz() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SCENE), &world.path("out"), "default");
    pilot.wait_live();
    let bus = Bus::join(&RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let poses = Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 4096).unwrap();
    let beats = Subscriber::<Heartbeat>::open(&bus, &HEARTBEAT, "tracker", 1).unwrap();
    let beat = |what| wait_for(what, || beats.newest().unwrap());
    let pid = pilot.pid("tracker").unwrap();
    let (first, cpu, began) = (beat("a beat"), cpu_s(pid), bus.clock().now_ns());
    let (mut seqs, mut latencies) = (Vec::new(), Vec::new());
    while bus.clock().now_ns() < began + 10_000_000_000 {
        while let Some(pose) = poses.next().unwrap() {
            seqs.push(pose.seq);
            latencies.push(pose.t_publish_ns - pose.t_capture_ns);
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let wall_s = clock::ms(bus.clock().now_ns() - began) / 1e3;
    let cpu = cpu_s(pid) - cpu;
    let published = beat("a beat").counters.published - first.counters.published;
    let span = seqs.last().unwrap() - seqs[0] + 1;
    latencies.sort_unstable();
    let at = |share: f64| clock::ms(latencies[((latencies.len() - 1) as f64 * share) as usize]);
    let load = fs::read_to_string("/proc/loadavg").unwrap();
    println!(
        "{:.0} poses/s received, {published} published, {} of {span} numbers missing, tracker {:.1} % of a core, {:.1} us a pose; \
         capture to publish p50 {:.3} ms, p99 {:.3} ms, max {:.3} ms; load {load}",
        seqs.len() as f64 / wall_s,
        span - seqs.len() as u64,
        100.0 * cpu / wall_s,
        1e6 * cpu / seqs.len() as f64,
        at(0.5),
        at(0.99),
        at(1.0),
    );
    assert!(pilot.stop().success());
}
