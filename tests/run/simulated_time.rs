//! Runs in simulated time: the same scene and seed give the same pictures and poses, however busy the machine is.

#![allow(clippy::disallowed_methods, reason = "a busy machine is made, and waited for")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::support::{SMALL, World, kill_9, pictures, wait_for};
use bus::Bus;
use bus::message::{FrameStamp, ToolPose};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::{FRAME_STAMP, TOOL_POSE as POSES};
use recorder::read::reader;
use recorder::wire::schema::{GROUND_TRUTH, TOOL_POSE};
use serde_json::Value;

fn poses(out: &Path, topic: &str) -> Vec<ToolPose> {
    let poses = reader::poses(&out.join("session.mcap"), topic).unwrap();
    poses.map(Result::unwrap).collect()
}

/// More work than the machine has processors, until it is dropped.
struct Load(Arc<AtomicBool>);

impl Load {
    fn new(threads: usize) -> Self {
        let on = Arc::new(AtomicBool::new(true));
        for _ in 0..threads {
            let on = Arc::clone(&on);
            std::thread::spawn(move || {
                while on.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        Self(on)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

const SCENES: [(&str, &str); 2] = [
    ("simulated", "source = \"simulated\"\ndropout = 0.05\n"),
    ("operating-room", "source = \"operating-room\"\n"),
];

#[test]
fn a_busy_machine_changes_no_byte() {
    for (name, tracker) in SCENES {
        let world = World::new();
        let scene = world.file(
            "s.toml",
            &SMALL.replace("[tracker]\n", &format!("[tracker]\n{tracker}")),
        );
        let arguments = ["--for", "1500ms", "--speed", "max"];
        let (calm, busy) = (world.path("calm"), world.path("busy"));
        let report = world.navigate(&scene, &calm, &arguments);
        let load = Load::new(8);
        let under_load = world.navigate(&scene, &busy, &arguments);
        drop(load);
        assert_eq!(
            (&report["duration_s"], &report["simulated_time"]),
            (&1.5.into(), &true.into())
        );
        for key in ["poses", "accuracy", "views", "problems"] {
            assert_eq!(report[key], under_load[key], "{name}: {key}");
        }
        let count = |key: &str| report["poses"][key].as_u64().unwrap();
        assert!(count("published") >= 85, "{name}: {}", report["poses"]);
        for view in report["views"].as_array().unwrap() {
            assert_eq!(view["rendered"], count("published") - count("lost"), "{name}: {view}");
            assert_eq!(view["unflagged_old"], 0);
        }
        assert!(pictures(&calm) == pictures(&busy), "{name}");
        for topic in [TOOL_POSE, GROUND_TRUTH] {
            let [calm, busy] = [&calm, &busy].map(|out| poses(out, topic));
            assert_eq!(calm.len() as u64, count("published"), "{name}: {topic}");
            assert!(calm == busy, "{name}: {topic}");
        }
        // Stamps count from sample 0, as the localizer's own do.
        let recorded = poses(&calm, TOOL_POSE);
        let since = |pose: &ToolPose| pose.t_capture_ns - recorded[0].t_capture_ns;
        assert!(name != "simulated" || recorded.iter().all(|pose| pose.t_device_ns == since(pose)));
    }
}

#[test]
fn the_pictures_are_those_of_an_ordinary_run() {
    let world = World::new();
    let scene = world.file("s.toml", SMALL);
    let (ordinary, simulated) = (world.path("ordinary"), world.path("simulated"));
    world.navigate(&scene, &ordinary, &["--for", "1s"]);
    world.navigate(&scene, &simulated, &["--for", "1s", "--speed", "max"]);
    assert!(pictures(&ordinary) == pictures(&simulated));
}

/// Starts a run of `length` in simulated time, kills `process` in the middle, and gives its exit code and its report.
fn killed(world: &World, process: &str, length: &str) -> (Option<i32>, Value) {
    let (scene, out) = (world.file("s.toml", SMALL), world.path("out"));
    let arguments = ["--for", length, "--speed", "max", "--headless", "--out"];
    let mut command = world.command("pilot");
    let mut child = command
        .arg("run")
        .arg(&scene)
        .args(arguments)
        .arg(&out)
        .spawn()
        .unwrap();
    let bus = Bus::join(&wait_for("the run", || {
        RunContext::load(&world.run_dir("default")).ok()
    }))
    .unwrap();
    let heard = Subscriber::<ToolPose>::open(&bus, &POSES, "", 1).unwrap();
    let stamps = Subscriber::<FrameStamp>::open(&bus, &FRAME_STAMP, "view-axial", 1).unwrap();
    wait_for("a hundred poses", || {
        let pose = heard.newest().unwrap();
        pose.filter(|pose| pose.seq > 100)
    });
    let stamp = wait_for("an image", || stamps.newest().unwrap());
    assert_eq!(stamp.replay, 2, "images in simulated time say so");
    let status = world.output("pilot", &["status", "--json"]);
    let status: Value = serde_json::from_slice(&status.stdout).unwrap();
    assert!(
        !crate::support::all_live(&status),
        "nothing is live in simulated time: {status:#}"
    );
    kill_9(crate::support::pid_in(&status, process).unwrap());
    drop((heard, stamps, bus));
    let ended = wait_for("the run's end", || child.try_wait().unwrap());
    (ended.code(), crate::support::report(&out))
}

#[test]
fn a_killed_renderer_or_tracker_comes_back_and_nothing_is_left_out() {
    for process in ["view-frontal", "tracker"] {
        let (code, report) = killed(&World::new(), process, "12s");
        assert_eq!(report["restarts"][0]["process"], process, "{:#}", report["restarts"]);
        // The death is told, and it is all there is to tell.
        let problems = report["problems"].as_array().unwrap();
        let died = format!("{process} ended once before the run did");
        assert!(
            code == Some(3) && problems.len() == 1 && problems[0].as_str().unwrap().starts_with(&died),
            "{code:?} {problems:?}"
        );
        for (key, expected) in [("published", 720), ("lost", 0), ("refused", 0), ("missing", 0)] {
            assert_eq!(report["poses"][key], expected, "{process} {key}");
        }
        assert_eq!(report["views"][0]["seq"], 719, "{process}");
    }
}

#[test]
fn what_cannot_run_in_simulated_time_is_refused_by_name() {
    let room = crate::support::room::Room::new();
    let output = |scene: &Path, more: &[&str]| {
        let (scene, out) = (scene.to_str().unwrap(), room.out.to_str().unwrap());
        room.output(
            "pilot",
            &[&["run", scene, "--headless", "--out", out, "--speed"], more].concat(),
        )
    };
    let without = output(&room.good, &["max"]);
    assert!(
        crate::support::stderr(&without).contains("--for <TIME>"),
        "{}",
        crate::support::stderr(&without)
    );
    for source in ["external", "emitters"] {
        let text = SMALL.replace("[tracker]\n", &format!("[tracker]\nsource = {source:?}\n"));
        let output = output(&room.file("s.toml", &text), &["max", "--for", "1s"]);
        room.is_refused(&output, &format!("--speed max | tracker.source = {source:?}"));
    }
    let probe = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n") + "[tracker.room.probe]\n";
    let output_of_probe = output(&room.file("s.toml", &probe), &["max", "--for", "1s"]);
    room.is_refused(&output_of_probe, "--speed max | tracker.room.probe");
    let slow = output(&room.good, &["2", "--for", "1s"]);
    assert!(
        crate::support::stderr(&slow).contains("possible values: max"),
        "{}",
        crate::support::stderr(&slow)
    );
}
