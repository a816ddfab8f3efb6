//! Frames of emitters that a recording lacks: what a replay that makes poses again shows in their place.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::support::{Pilot, SMALL, World, stderr};
use bus::message::{EmitterFrame, ToolPose};
use recorder::read::reader;
use recorder::wire::proto;
use recorder::wire::schema::{RunFacts, Source, TOOL_POSE};
use recorder::write::pose_log::Entry;
use recorder::write::session_file::{Content, SessionFile};

/// The recording with all its poses and without the frames of these numbers.
fn without(world: &World, recording: &Path, left_out: &[u64]) -> PathBuf {
    let scene = reader::beside(recording).unwrap().scene.unwrap();
    let facts = RunFacts {
        name: "live".to_owned(),
        epoch_ns: 0,
        registration_id: None,
        volume_hash: None,
        remade_from: None,
    };
    let path = world.path("gaps.mcap");
    let content = Content::new(&world.file("attached.toml", &scene), &facts);
    let mut file = SessionFile::create(&path, &content).unwrap();
    let frames = reader::emitters(recording).unwrap().map(Result::unwrap);
    for frame in frames.filter(|frame: &EmitterFrame| !left_out.contains(&frame.seq)) {
        let frame = proto::EmitterFrame::try_from(&frame).unwrap();
        file.put(Entry::Emitters(&frame)).unwrap();
    }
    for pose in reader::poses(recording, TOOL_POSE).unwrap().map(Result::unwrap) {
        file.put(Entry::Pose(Source::Tool, &pose)).unwrap();
    }
    file.finish().unwrap().path
}

/// A step at a pose whose frame is missing showed nothing: the same image stood there, and the next step went on from it.
#[test]
fn a_step_at_a_missing_frame_shows_the_next_that_there_is() {
    let world = World::new();
    let scene = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n");
    let scene = world.file("room.toml", &scene);
    world.navigate(&scene, &world.path("live"), &["--for", "1s"]);
    let recording = world.path("live").join("session.mcap");
    let poses: Vec<ToolPose> = reader::poses(&recording, TOOL_POSE)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let seq = |place: usize| poses[place].seq;
    let gaps = without(&world, &recording, &[seq(21), seq(22)]);
    // So slowly that it stands at its first pose until it is paused.
    let from_s = (poses[20].t_publish_ns - poses[0].t_publish_ns - 1_000_000) as f64 / 1e9;
    let child = world
        .command("pilot")
        .args([
            "replay",
            &gaps.to_string_lossy(),
            "--recompute",
            "--force",
            "--headless",
            "--run",
            "again",
        ])
        .args(["--speed", "0.01", "--from", &format!("{from_s:.9}s")])
        .args(["--out", &world.path("again").to_string_lossy()])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let pilot = Pilot::of(&world, "again", child);
    let shows = |seq: u64| {
        pilot.wait_for(&format!("pose {seq}"), |status| {
            status["views"]
                .as_array()
                .unwrap()
                .iter()
                .all(|view| view["seq"] == seq)
        });
    };
    let steer = |how: &str| {
        let output = world.output("pilot", &["replay-control", "--run", "again", how]);
        assert!(output.status.success(), "{}", stderr(&output));
    };
    shows(seq(20));
    steer("pause");
    steer("step");
    shows(seq(23));
    steer("step");
    shows(seq(24));
    let _ = pilot.stop();
}
