//! A measurement that stood still in a recording: images, moments, bar and report say the same of it, wherever a replay goes.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::support::{Pilot, SMALL, World, stderr};
use bus::message::{ToolPose, Tracked};
use geometry::{Rigid, Vector};
use recorder::wire::schema::{RunFacts, Source};
use recorder::write::pose_log::Entry;
use recorder::write::session_file::{Content, SessionFile};
use serde_json::Value;

/// When the measurement stood still, s of the recording; the limit of the scene is 0.5 s.
const STANDS_S: [f64; 2] = [1.0, 3.0];

/// Five seconds at 60 Hz.
fn recording(world: &World, name: &str, scene: &str) -> PathBuf {
    let scene = world.file(&format!("{name}.toml"), scene);
    let facts = RunFacts {
        name: "before".to_owned(),
        epoch_ns: 0,
        registration_id: None,
        volume_hash: None,
        remade_from: None,
    };
    let path = world.path(&format!("{name}.mcap"));
    let mut file = SessionFile::create(&path, &Content::new(&scene, &facts)).unwrap();
    for seq in 0..300_u64 {
        let s = seq as f64 / 60.0;
        let [from_s, to_s] = STANDS_S;
        let x = if (from_s..=to_s).contains(&s) { from_s } else { s };
        let t_ns = bus::clock::seconds(s);
        let mut pose = ToolPose {
            seq,
            t_capture_ns: t_ns,
            t_publish_ns: t_ns + 1_000_000,
            ..ToolPose::EMPTY
        };
        let at = Rigid::from_rotation_vector(Vector::new(1.0, 0.5, 0.0), Vector::new(x, 0.0, 40.0));
        pose.set(Tracked::Valid(at.unwrap()));
        file.put(Entry::Pose(Source::Tool, &pose)).unwrap();
        if seq % 30 == 29 {
            file.flush().unwrap();
        }
    }
    file.finish().unwrap().path
}

fn start<'a>(world: &'a World, recording: &Path, run: &str, arguments: &[&str]) -> Pilot<'a> {
    let child = world
        .command("pilot")
        .args([
            "replay",
            &recording.to_string_lossy(),
            "--headless",
            "--force",
            "--run",
            run,
        ])
        .args(["--out", &world.path(run).to_string_lossy()])
        .args(arguments)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    Pilot::of(world, run, child)
}

fn steer(world: &World, run: &str, how: &[&str]) {
    let output = world.output("pilot", &[&["replay-control", "--run", run], how].concat());
    assert!(output.status.success(), "{}", stderr(&output));
}

/// Whether every view shows pose `seq` in this state.
fn shows(status: &Value, state: &str, seq: u64) -> bool {
    let views = status["views"].as_array().unwrap();
    views.iter().all(|view| view["state"] == state && view["seq"] == seq)
}

/// The facts of the moment that is shown.
fn moment(world: &World, run: &str, seq: u64) -> Value {
    steer(world, run, &["moment"]);
    let ms = bus::clock::seconds(seq as f64 / 60.0) / 1_000_000;
    let path = world.path(run).join(format!("moments/pose-{seq:06}-{ms}/moment.json"));
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// The bar and the report called these poses FROZEN, and the images of the same poses were good ones, in a moment too.
#[test]
fn what_stood_still_is_frozen_wherever_a_replay_goes() {
    let world = World::new();
    let text = SMALL.replace("[tracker]", "[tracker]\nsource = \"external\"");
    let recording = recording(&world, "s", &text);
    // By the report: from 0.5 s behind the first of these measurements on, until the next one comes.
    let out = world.path("report.html");
    let arguments = [
        "report",
        &recording.to_string_lossy(),
        "--json",
        "--out",
        &out.to_string_lossy(),
    ];
    let output = world.output("recorder", &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&std::fs::read(world.path("report.json")).unwrap()).unwrap();
    let lost = &report["lost_longest"][0];
    let span_ns = ["from_ns", "to_ns"].map(|key| lost[key].as_i64().unwrap());
    assert_eq!(lost["why"], "FROZEN MEASUREMENT", "{report:#}");
    let seconds = |ns: i64| ns as f64 / 1e9;
    assert!(
        (seconds(span_ns[0]) - 1.5).abs() < 0.02 && (seconds(span_ns[1]) - 3.0).abs() < 0.03,
        "{span_ns:?}"
    );

    let pilot = start(&world, &recording, "again", &["--loop"]);
    pilot.wait_for("a replay", |status| status["replay"]["state"] == "playing");
    steer(&world, "again", &["pause"]);
    // Into it, before it, just behind its beginning, at its last pose, behind it, and back again.
    for s in [2.0, 0.5, 1.25, 1.6, 2.9, 3.5, 2.5, 0.0, 4.9, 1.4] {
        let seq = (s * 60.0_f64).round() as u64;
        steer(&world, "again", &["seek", &format!("{s}s")]);
        let due_ns = bus::clock::seconds(s) + 1_000_000;
        let is_frozen = (span_ns[0]..span_ns[1]).contains(&due_ns);
        let state = if is_frozen { "lost" } else { "replay" };
        let status = pilot.wait_for(&format!("{s} s"), |status| shows(status, state, seq));
        let said = &status["pose"]["state"];
        assert_eq!(said == "FROZEN MEASUREMENT", is_frozen, "{s} s: {status:#}");
        let moment = moment(&world, "again", seq);
        let images = moment["images"].as_array().unwrap().len();
        assert_eq!(
            moment["status"] == "lost: FROZEN MEASUREMENT",
            is_frozen,
            "{s} s: {moment:#}"
        );
        assert_eq!(
            (images == 0, moment["pose"].is_null()),
            (is_frozen, is_frozen),
            "{s} s: {moment:#}"
        );
        // Before the first pose there is nothing to judge it beside, and nothing that it could have stood still from.
        assert_eq!(moment["standstill_judged"], true, "{s} s: {moment:#}");
    }
    // Over its beginning by single steps, forwards and backwards: pose 91 is the first that is too long behind pose 60.
    steer(&world, "again", &["seek", "1.5s"]);
    pilot.wait_for("pose 90", |status| shows(status, "replay", 90));
    for (how, state, seq) in [
        ("step", "lost", 91),
        ("step", "lost", 92),
        ("back", "lost", 91),
        ("back", "replay", 90),
    ] {
        steer(&world, "again", &[how]);
        pilot.wait_for(&format!("pose {seq}"), |status| shows(status, state, seq));
    }
    let _ = pilot.stop();
    // Begun in the middle of it.
    let pilot = start(&world, &recording, "within", &["--from", "2s", "--speed", "0.01"]);
    pilot.wait_for("a frozen measurement from the first image on", |status| {
        let frozen = |view: &Value| view["state"] == "lost";
        // Never a good image before.
        assert!(
            status["views"]
                .as_array()
                .unwrap()
                .iter()
                .all(|view| view["state"] != "replay"),
            "{status:#}"
        );
        status["views"].as_array().unwrap().iter().all(frozen) && status["pose"]["state"] == "FROZEN MEASUREMENT"
    });
    let _ = pilot.stop();
}

/// Poses of a simulator without noise say that they have none; before they did, its scene does.
#[test]
fn an_old_recording_of_a_simulator_without_noise_is_not_lost() {
    let world = World::new();
    let text = SMALL.replace("[tracker]", "[tracker]\nnoise_mm = 0.0\nnoise_deg = 0.0");
    let recording = recording(&world, "s", &text);
    let pilot = start(&world, &recording, "again", &["--loop"]);
    pilot.wait_for("a replay", |status| status["replay"]["state"] == "playing");
    steer(&world, "again", &["pause"]);
    steer(&world, "again", &["seek", "2.5s"]);
    pilot.wait_for("a tool at rest", |status| shows(status, "replay", 150));
    assert_eq!(moment(&world, "again", 150)["status"], "valid");
    let _ = pilot.stop();
    let out = world.path("report.html");
    let arguments = [
        "report",
        &recording.to_string_lossy(),
        "--json",
        "--out",
        &out.to_string_lossy(),
    ];
    assert!(world.output("recorder", &arguments).status.success());
    let report: Value = serde_json::from_slice(&std::fs::read(world.path("report.json")).unwrap()).unwrap();
    assert_eq!(report["poses"]["valid"], 300, "{report:#}");
}
