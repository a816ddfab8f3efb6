//! One command, all processes, pictures that rest on one pose.

#![allow(clippy::disallowed_methods, reason = "the system is asked what it allows")]

use std::path::{Path, PathBuf};

use crate::support::nifti::Nifti;
use crate::support::{Pilot, SMALL, World, png_texts, shared};
use serde_json::Value;

const STAGES: [&str; 5] = [
    "capture_to_publish",
    "publish_to_seen",
    "seen_to_rendered",
    "rendered_to_framed",
    "pose_to_pixels",
];

fn names(report: &Value) -> Vec<&str> {
    report["views"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v["name"].as_str().unwrap())
        .collect()
}

/// Every picture of a run shows the same pose, registration and volume, and says so in the file.
fn check_pictures(out: &Path, report: &Value, seq: u64) {
    for view in report["views"].as_array().unwrap() {
        let png = out.join(view["png"].as_str().expect("each view has a picture"));
        let texts = png_texts(&png);
        assert_eq!(view["seq"], seq, "{view}");
        assert_eq!(texts["pose_seq"], seq.to_string());
        assert_eq!(texts["pose_state"], "valid");
        assert_eq!(texts["volume_hash"], report["volume"]["hash"].as_str().unwrap());
        assert_eq!(texts["registration_id"], report["registration_id"].as_str().unwrap());
        assert_eq!(texts["view"], view["name"].as_str().unwrap());
        let image = image::open(&png).unwrap();
        let size = [image.width(), image.height()].map(Value::from);
        assert_eq!(view["size"].as_array().unwrap()[..], size);
        let grey = image.to_luma8();
        let bright = grey.pixels().filter(|p| p[0] > 25).count();
        assert!(bright * 10 > grey.len(), "{} is black", png.display());
    }
    assert_eq!(png_texts(&out.join("sheet.png"))["pose_seq"], seq.to_string());
}

#[test]
fn a_run_leaves_pictures_recording_and_report() {
    let world = World::new();
    let (scene, out) = (world.file("s.toml", SMALL), world.path("out"));
    let report = world.navigate(&scene, &out, &["--for", "1500ms"]);

    assert_eq!(names(&report), ["axial-global", "frontal-local", "perpendicular"]);
    // The last of 1.5 s at 60 Hz, while the tube sweeps inside the body.
    check_pictures(&out, &report, 89);
    assert_eq!(report["seed"], 1);
    assert_eq!(report["volume"]["dims"], serde_json::json!([60, 44, 60]));
    assert_eq!(report["recording"], serde_json::json!(["session.mcap"]));
    assert!(report["problems"].as_array().unwrap().is_empty());
    assert!(report["restarts"].as_array().unwrap().is_empty());
    for stage in STAGES {
        for key in ["p50", "p95", "p99", "max"] {
            assert!(
                report["latency_ms"][stage][key].as_f64().is_some_and(|ms| ms >= 0.0),
                "{stage}.{key}"
            );
        }
    }
    for view in report["views"].as_array().unwrap() {
        let (shown, dropped) = (view["rendered"].as_u64().unwrap(), view["dropped"].as_u64().unwrap());
        assert_eq!(shown + dropped, report["poses"]["published"].as_u64().unwrap());
        assert_eq!(view["unflagged_old"], 0);
    }
    // One copy for all: the volume is mapped, not copied. Bricks may add 4.7 % and the last page a little.
    let ratio = report["memory"]["volume_ratio"].as_f64().unwrap();
    assert!((0.9..=1.06).contains(&ratio), "{ratio}");
}

#[test]
fn nothing_is_left_behind() {
    let world = World::new();
    let (scene, out) = (world.file("s.toml", SMALL), world.path("out"));
    world.navigate(&scene, &out, &["--for", "500ms"]);
    let prefix = bus::run::RunContext::new(&world.run_dir("default"), 0)
        .unwrap()
        .folder_prefix();
    let left: Vec<_> = std::fs::read_dir(bus::run::SHM_DIR)
        .unwrap()
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with(&prefix))
        .collect();
    assert!(left.is_empty(), "{left:?}");
    let parts = std::fs::read_dir(&out).unwrap().flatten().filter(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        name.ends_with(".part") || name.ends_with(".recording")
    });
    assert_eq!(parts.count(), 0);
}

#[test]
fn the_same_seed_gives_the_same_pictures() {
    let world = World::new();
    let scene = world.file("s.toml", SMALL);
    let pictures = |name: &str, seed: &str| {
        let out = world.path(name);
        let report = world.navigate(
            &scene,
            &out,
            &["--for", "1s", "--speed", "max", "--seed", seed, "--run", name],
        );
        let mut files: Vec<String> = names(&report).iter().map(|v| format!("{v}.png")).collect();
        files.push("sheet.png".to_owned());
        files
            .iter()
            .map(|file| std::fs::read(out.join(file)).unwrap())
            .collect::<Vec<_>>()
    };
    let first = pictures("a", "1");
    assert!(first == pictures("b", "1"), "the same seed gave other bytes");
    assert!(first != pictures("c", "2"), "another seed gave the same bytes");
}

#[test]
fn two_runs_side_by_side_do_not_see_each_other() {
    let world = World::new();
    let scene = world.file("s.toml", SMALL);
    let first = world.start(&scene, &world.path("a"), "a");
    let second = world.start(&scene, &world.path("b"), "b");
    first.wait_live();
    second.wait_live();
    assert!(first.stop().success());
    second.wait_live();
    assert!(second.stop().success());
    for name in ["a", "b"] {
        let report = crate::support::report(&world.path(name));
        assert_eq!(report["run"], name);
        assert!(report["restarts"].as_array().unwrap().is_empty(), "{report}");
    }
}

#[test]
fn a_scene_starts_only_what_it_names() {
    let world = World::new();
    let one = SMALL.split("[[views]]").take(2).collect::<Vec<_>>().join("[[views]]");
    let scene = world.file("one.toml", &one.replace("[recording]", ""));
    let pilot = world.start(&scene, &world.path("out"), "one");
    let status = pilot.wait_live();
    let processes: Vec<_> = status["processes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p["name"].as_str().unwrap())
        .collect();
    assert_eq!(processes, ["volume-loader", "view-axial", "tracker"]);
    assert!(pilot.stop().success());
    assert!(!world.path("out/session.mcap").exists());
}

/// What the renderer of the axial views says of itself, in a status or a report.
fn note(of_run: &Value) -> &str {
    let processes = of_run["processes"].as_array().unwrap();
    let view = processes.iter().find(|p| p["name"] == "view-axial").unwrap();
    view["note"].as_str().unwrap()
}

/// A run, its output folder and its status when it is settled who draws.
fn settled<'a>(world: &'a World, back_end: &str, scene: &str) -> (Pilot<'a>, PathBuf, Value) {
    let scene = world.file("s.toml", &format!("{scene}[render]\nback_end = \"{back_end}\"\n"));
    let out = world.path(back_end);
    let pilot = world.start(&scene, &out, "default");
    pilot.wait_live();
    let status = pilot.wait_for("somebody who draws", |status| !note(status).contains("being tried"));
    (pilot, out, status)
}

/// With a card, also a software one, its name once it has proved itself; without any, the CPU's with the reason.
#[test]
fn the_report_says_who_drew() {
    let world = World::new();
    for (back_end, word) in [("cpu", "cpu"), ("auto", ""), ("gpu", "")] {
        let (pilot, out, status) = settled(&world, back_end, SMALL);
        assert!(pilot.stop().success());
        let report = crate::support::report(&out);
        let drew = note(&report);
        println!("{back_end}: {drew}");
        // With the memory that it takes by then.
        assert_eq!(drew.split(" MiB").next(), note(&status).split(" MiB").next());
        assert!(drew.starts_with("cpu") || drew.starts_with("gpu"), "{drew}");
        assert!(drew.starts_with(word), "{back_end}: {drew}");
    }
}

/// A volume longer than the textures of a card: the CPU draws it, and the run says that the card is not used.
#[test]
fn a_card_that_cannot_be_used_is_a_problem_of_the_run() {
    let world = World::new();
    let voxels = (0..2 * 2 * 16_000_u32).flat_map(|i| ((i % 700) as i16).to_le_bytes());
    let long = Nifti::header()
        .dims([2, 2, 16_000])
        .f32(88, 0.02)
        .f32(320, 0.02)
        .with(voxels);
    std::fs::write(world.path("long.nii"), Vec::from(long)).unwrap();
    let scene = SMALL.replace("source = \"phantom\"\nspacing_mm = 6.0", "source = \"long.nii\"");
    let (pilot, out, status) = settled(&world, "gpu", &scene);
    if !note(&status).contains("GPU given up") {
        println!("skipped: no GPU, or one with longer textures: {}", note(&status));
        return;
    }
    assert!(note(&status).contains("(GPU given up, unusable: "), "{status}");
    assert_eq!(pilot.stop().code(), Some(3));
    let problems = crate::support::report(&out)["problems"].to_string();
    assert!(
        problems.contains("view-axial: cpu") && problems.contains("a volume of 2 x 2 x 16000 v"),
        "{problems}"
    );
}

#[test]
fn dropouts_are_published_as_lost_and_never_shown() {
    let world = World::new();
    let text = SMALL.replace("rate_hz = 60.0", "rate_hz = 60.0\ndropout = 0.05\ndropout_samples = 4");
    let (scene, out) = (world.file("s.toml", &text), world.path("out"));
    let report = world.navigate(&scene, &out, &["--for", "2s"]);
    let (published, lost) = (
        report["poses"]["published"].as_u64().unwrap(),
        report["poses"]["lost"].as_u64().unwrap(),
    );
    assert!(lost > 0 && lost < published / 2, "{lost} of {published}");
    for view in report["views"].as_array().unwrap() {
        assert!(view["rendered"].as_u64().unwrap() <= published - lost);
    }
    // The last sample may be a lost one; the pictures show the last valid one.
    let seq = report["views"][0]["seq"].as_u64().unwrap();
    check_pictures(&out, &report, seq);
}

#[test]
fn a_real_ct_runs_and_is_held_once() {
    let Some(ct) = shared("data/ct-abdopelvis-nifti/example_ct.nii.gz") else {
        return;
    };
    let world = World::new();
    let (scene, out) = (world.file("s.toml", SMALL), world.path("out"));
    let report = world.navigate(&scene, &out, &["--for", "1s", "--volume", &ct.to_string_lossy()]);
    check_pictures(&out, &report, 59);
    assert_eq!(report["volume"]["dims"], serde_json::json!([122, 101, 112]));
    // RAS becomes LPS here: +x of the file is the patient's right, which is -x of ours.
    let rows = &report["volume"]["ct_from_voxel"];
    assert_eq!(rows[0][0], -3.0);
    assert_eq!(rows[1][1], -3.0);
    assert_eq!(rows[2][2], 3.0);
}

const NICE: usize = 16;
const REAL_TIME_PRIORITY: usize = 37;
const POLICY: usize = 38;

/// A field of `/proc/PID/stat` of every thread of a process, counted from the name in brackets.
fn of_threads(pid: u64, field: usize) -> Vec<i64> {
    let tasks = std::fs::read_dir(format!("/proc/{pid}/task")).unwrap().flatten();
    let lines = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("stat")).ok());
    lines
        .filter_map(|line| line.rsplit_once(')')?.1.split_whitespace().nth(field)?.parse().ok())
        .collect()
}

#[test]
fn processes_have_the_priorities_of_the_scene() {
    let world = World::new();
    // A graphics driver gives its threads priorities of its own.
    let scene = format!(
        "{SMALL}[render]\nback_end = \"cpu\"\n[priorities]\ntracker = 1\nrenderers = 2\nrecorder = 3\nvolume_loader = 4\n"
    );
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    let status = pilot.wait_live();
    for process in status["processes"].as_array().unwrap() {
        let expected = match process["name"].as_str().unwrap() {
            "tracker" => 1,
            "recorder" => 3,
            "volume-loader" => 4,
            _ => 2,
        };
        let found = of_threads(process["pid"].as_u64().unwrap(), NICE);
        assert!(
            !found.is_empty() && found.iter().all(|nice| *nice == expected),
            "{process}: {found:?}"
        );
    }
    assert!(pilot.stop().success());
}

#[test]
fn tracker_and_renderers_have_the_real_time_priority_that_the_scene_asks_for() {
    let allowed = std::process::Command::new("chrt").args(["-r", "10", "true"]).status();
    if !allowed.is_ok_and(|status| status.success()) {
        println!("skipped: this system allows no real-time priority, or has no chrt to ask it");
        return;
    }
    let world = World::new();
    let scene = format!("{SMALL}[render]\nback_end = \"cpu\"\n[priorities]\nreal_time = true\n");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    let status = pilot.wait_live();
    for process in status["processes"].as_array().unwrap() {
        let name = process["name"].as_str().unwrap();
        // SCHED_RR is 2.
        let expected = if name == "tracker" || name.starts_with("view-") {
            [10, 2]
        } else {
            [0, 0]
        };
        for (field, expected) in [REAL_TIME_PRIORITY, POLICY].into_iter().zip(expected) {
            let found = of_threads(process["pid"].as_u64().unwrap(), field);
            assert!(
                !found.is_empty() && found.iter().all(|x| *x == expected),
                "{name}: {found:?}"
            );
        }
    }
    assert!(pilot.stop().success());
}
