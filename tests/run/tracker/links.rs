//! Calibration and registration from files, while a run is going: without them there is no pose and the operator reads why;
//! once they are put right there is one again, and what it says of its error is true.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::support::links::{MARKER_FROM_TOOL_MM, register, tool_json, volume_hash};
use crate::support::{Pilot, SMALL, World, all_live, wait_for};
use bus::Bus;
use bus::message::{EmitterFrame, ToolPose, Tracked};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::{EMITTERS, GROUND_TRUTH, TOOL_POSE};
use geometry::{Ct, Point, Tool};
use serde_json::Value;

const FILES: &str = "[tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n\
                     [tracker.registration]\nfile = \"registration.json\"\n[tracker.room.marker]\ncone_deg = 180.0\n";

fn scene() -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n") + FILES
}

fn note(status: &Value) -> &str {
    let processes = status["processes"].as_array().unwrap();
    let tracker = processes.iter().find(|p| p["name"] == "tracker").unwrap();
    tracker["note"].as_str().unwrap()
}

/// Waits until there is no pose for `lost`, with these words from the tracker, and no view shows one.
fn wait_lost(pilot: &Pilot<'_>, lost: &str, words: &str) {
    pilot.wait_for(&format!("{lost:?} with {words:?}"), |status| {
        let views = status["views"].as_array().unwrap();
        status["pose"]["state"] == lost
            && note(status).contains(words)
            && views.iter().all(|view| view["state"] == "lost")
    });
}

/// Replaces a file at once, as an editor does.
fn put(path: &Path, text: &str) {
    let part = path.with_extension("part");
    fs::write(&part, text).unwrap();
    fs::rename(part, path).unwrap();
}

#[test]
fn files_come_and_go_and_the_poses_with_them() {
    let world = World::new();
    let (tool, registration) = (world.path("tool.json"), world.path("registration.json"));
    let good = tool_json("mediastinoscope", "ball", MARKER_FROM_TOOL_MM);
    let pilot = world.start(&world.file("s.toml", &scene()), &world.path("out"), "default");
    wait_lost(
        &pilot,
        "tool not calibrated",
        "tool not calibrated: tool.json is not there",
    );
    put(&tool, &tool_json("pointer", "ball", MARKER_FROM_TOOL_MM));
    wait_lost(
        &pilot,
        "tool not calibrated",
        "made for the tool \"pointer\", in use is \"mediastinoscope\"",
    );
    put(&tool, &tool_json("mediastinoscope", "star", MARKER_FROM_TOOL_MM));
    wait_lost(&pilot, "tool not calibrated", "made for the marker \"star\"");
    put(&tool, &good.replace("280.0", "281.0"));
    wait_lost(&pilot, "tool not calibrated", "changed after it was");
    put(
        &tool,
        &good.replace("\"trocar_calibration\": 1", "\"trocar_calibration\": 9"),
    );
    wait_lost(&pilot, "tool not calibrated", "found trocar_calibration 9, expected");
    put(&tool, &good);
    wait_lost(&pilot, "patient not registered", "registration.json is not there");

    let bus = Bus::join(&RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let hash = volume_hash(&bus);
    register(&world, "tracker", &"ab".repeat(32), &registration);
    wait_lost(&pilot, "patient not registered", "made for the CT \"abab");
    register(&world, "reference", &hash, &registration);
    wait_lost(
        &pilot,
        "patient not registered",
        "rests on a reference, and the scene has none",
    );
    register(&world, "tracker", &hash, &registration);
    let status = pilot.wait_live();
    let tip = status["pose"]["tip_95_mm"].as_f64().unwrap();
    // The files say 0.1 mm along each axis for the tool; the registration of 0.2 mm and the emitters come to it.
    assert!((0.28..2.0).contains(&tip), "{tip}");

    fs::remove_file(&tool).unwrap();
    wait_lost(&pilot, "tool not calibrated", "tool.json is not there");
    put(&tool, &good);
    pilot.wait_live();
    assert!(pilot.stop().success());
    let report = crate::support::report(&world.path("out"));
    let lost = &report["accuracy"]["lost"];
    assert!(lost["tool not calibrated"].as_u64() > Some(20), "{lost}");
    assert!(lost["patient not registered"].as_u64() > Some(20), "{lost}");
    // What images and report name is the registration of the file, not the scene's.
    let own = scene::Scene::load(&world.path("s.toml")).unwrap().registration_id();
    assert_ne!(report["registration_id"], format!("{own:016x}"));
}

fn tip(pose: &ToolPose) -> Option<Point<Ct>> {
    match pose.tracked().unwrap() {
        Tracked::Valid(pose) => Some(pose * Point::<Tool>::new(0.0, 0.0, 0.0)),
        Tracked::Lost(_) => None,
    }
}

#[test]
fn poses_from_files_err_as_predicted_and_every_frame_goes_out_before_its_pose() {
    let world = World::new();
    let (tool, registration) = (world.path("tool.json"), world.path("registration.json"));
    fs::write(&tool, tool_json("mediastinoscope", "ball", [0.1, -60.1, 280.0])).unwrap();
    let pilot = world.start(&world.file("s.toml", &scene()), &world.path("out"), "default");
    wait_lost(&pilot, "patient not registered", "registration.json is not there");
    let bus = Bus::join(&RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    register(&world, "tracker", &volume_hash(&bus), &registration);
    let poses = Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 1024).unwrap();
    let truths = Subscriber::<ToolPose>::open(&bus, &GROUND_TRUTH, "", 1024).unwrap();
    let frames = Subscriber::<EmitterFrame>::open(&bus, &EMITTERS, "", 1024).unwrap();
    pilot.wait_for("every view live", all_live);
    let mut found = BTreeMap::new();
    wait_for("a hundred poses", || {
        found.extend(std::iter::from_fn(|| poses.next().unwrap()).map(|pose| (pose.seq, pose)));
        (found.values().filter(|pose| tip(pose).is_some()).count() > 100).then_some(())
    });
    let truths: BTreeMap<_, _> = std::iter::from_fn(|| truths.next().unwrap())
        .map(|t| (t.seq, t))
        .collect();
    let frames: BTreeMap<_, _> = std::iter::from_fn(|| frames.next().unwrap())
        .map(|f| (f.seq, f))
        .collect();
    assert!(pilot.stop().success());
    let mut checked = 0;
    for (seq, pose) in &found {
        let (Some(truth), Some(frame)) = (truths.get(seq), frames.get(seq)) else {
            continue;
        };
        assert!(frame.t_publish_ns <= pose.t_publish_ns && frame.t_device_ns == pose.t_device_ns);
        assert_eq!((frame.tool_seen, frame.t_capture_ns), (pose.visible, pose.t_capture_ns));
        let Some(at) = tip(pose) else { continue };
        let (off, predicted) = (at.distance(tip(truth).unwrap()), pose.tip_95_mm().unwrap());
        // The calibration is off by 0.14 mm and the registration by no more than its points; the noise of the emitters
        // alone would pass 2.5 times its 95 % radius once in a million.
        assert!(
            off < 2.5 * predicted,
            "{seq}: off by {off} mm, predicted {predicted} mm"
        );
        assert!(pose.used >= 4 && pose.used <= pose.visible);
        checked += 1;
    }
    assert!(checked > 50, "{checked}");
}
