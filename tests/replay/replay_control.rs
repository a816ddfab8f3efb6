//! A replay that is steered: pause, step, seek, speed; what it says of itself meanwhile.

use std::path::Path;
use std::process::Stdio;

use crate::support::{Pilot, SMALL, World, stderr, stdout};
use bus::Bus;
use bus::message::{Ages, Command, FrameStamp, FrameState};
use bus::port::{CommandClient, Frame, FrameSubscriber, Subscriber};
use bus::run::RunContext;
use bus::topic::{FRAME_STAMP, HELD_FRAME, VIEW_FRAME};
use recorder::read::reader;
use recorder::wire::schema::TOOL_POSE;
use serde_json::Value;

/// Starts a replay of `recording` that is steered under the name `again`.
fn start<'a>(world: &'a World, recording: &Path, arguments: &[&str]) -> Pilot<'a> {
    let child = world
        .command("pilot")
        .args(["replay", &recording.to_string_lossy(), "--headless", "--run", "again"])
        .args(["--out", &world.path("again").to_string_lossy()])
        .args(arguments)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    Pilot::of(world, "again", child)
}

/// Steers it; returns where it says it stands.
fn steer(world: &World, how: &[&str]) -> String {
    let output = world.output("pilot", &[&["replay-control", "--run", "again"], how].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    stdout(&output)
}

fn all_are(status: &Value, state: &str, seq: Option<u64>) -> bool {
    let views = status["views"].as_array().unwrap();
    let fits = |view: &Value| view["state"] == state && seq.is_none_or(|seq| view["seq"] == seq);
    views.iter().all(fits)
}

#[test]
fn a_replay_pauses_steps_seeks_and_never_says_that_it_is_live() {
    let world = World::new();
    let scene = world.file("small.toml", SMALL);
    world.navigate(&scene, &world.path("live"), &["--for", "2s"]);
    let recording = world.path("live").join("session.mcap");
    let poses: Vec<_> = reader::poses(&recording, TOOL_POSE)
        .unwrap()
        .map(Result::unwrap)
        .collect();

    let pilot = start(&world, &recording, &["--loop"]);
    pilot.wait_for("every view replayed", |status| all_are(status, "replay", None));
    assert!(steer(&world, &["pause"]).contains("paused"));
    // One second of recorded time is pose 60 or one beside it: the first at or after 1 s.
    let first_ns = poses[0].t_publish_ns;
    let place = poses
        .iter()
        .position(|p| p.t_publish_ns >= first_ns + 1_000_000_000)
        .unwrap();
    let (there, next) = (poses[place].seq, poses[place + 1].seq);
    steer(&world, &["seek", "1s"]);
    let status = pilot.wait_for("the place asked for", |status| all_are(status, "replay", Some(there)));
    assert_eq!(status["replay"]["state"], "paused");
    // A paused image does not grow old: not after twice the time that makes images old.
    std::thread::sleep(std::time::Duration::from_millis(2_000));
    let later = pilot.status().unwrap();
    assert!(all_are(&later, "replay", Some(there)), "{later:#}");

    // What is on the screen says that it is a replay; what is held does not, and is nobody's present.
    let bus = Bus::join(&RunContext::load(&world.run_dir("again")).unwrap()).unwrap();
    let frames = FrameSubscriber::open(&bus, &VIEW_FRAME, "axial-global").unwrap();
    steer(&world, &["step"]);
    pilot.wait_for("the next pose", |status| all_are(status, "replay", Some(next)));
    let moving = crate::support::wait_for("the image of the next pose", || {
        frames
            .newest()
            .unwrap()
            .filter(|frame| frame.header().stamp.seq == next)
    });
    assert_eq!(
        (moving.header().stamp.replay, moving.header().stamp.frame_state()),
        (1, Some(FrameState::Live))
    );
    // The frame around it is violet, in its corner too.
    let ages = Ages {
        stale_ns: i64::MAX,
        lost_ns: i64::MAX,
    };
    let pixels = |frame: &Frame| frame.shown(0, ages).rgba.to_vec();
    let corner: [u8; 3] = pixels(&moving)[..3].try_into().unwrap();
    assert!(corner[2] > 150 && corner[0] > corner[1], "{corner:?}");
    let held = FrameSubscriber::open(&bus, &HELD_FRAME, "axial-global").unwrap();
    let renderer = CommandClient::open(&bus, "view-axial").unwrap();
    let pose = poses.iter().find(|p| p.seq == next).unwrap();
    assert!(
        !renderer
            .ask(Command::render(*pose), crate::support::WATCHDOG)
            .unwrap()
            .refused
    );
    let still = crate::support::wait_for("the held image", || held.newest().unwrap());
    assert_eq!(still.header().stamp.seq, next);
    assert!(pixels(&still) != pixels(&moving));

    // What is shown, as files: the held image, and the recorded pose to the bit.
    let said = steer(&world, &["moment"]);
    let folder = world.path("again").join(format!(
        "moments/pose-{next:06}-{}",
        poses[place + 1].t_capture_ns / 1_000_000
    ));
    assert!(said.contains(&*folder.to_string_lossy()), "{said}");
    let canvas = image::open(folder.join("axial-global.png")).unwrap().to_rgba8();
    assert!(canvas.into_raw() == pixels(&still), "the file is not the held image");
    let text = std::fs::read_to_string(folder.join("moment.json")).unwrap();
    let moment: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(moment["pose"]["tip_mm"], serde_json::json!(pose.t_mm), "{moment:#}");
    assert_eq!(
        (&moment["same_examination"], &moment["left_out"]),
        (&true.into(), &Value::Array(vec![]))
    );
    // One back, and the first has none before it.
    steer(&world, &["back"]);
    pilot.wait_for("the pose before", |status| all_are(status, "replay", Some(there)));
    steer(&world, &["seek", "0s"]);
    pilot.wait_for("the first pose", |status| all_are(status, "replay", Some(poses[0].seq)));
    assert!(steer(&world, &["back"]).contains("paused"));
    pilot.wait_for("the first pose", |status| all_are(status, "replay", Some(poses[0].seq)));

    // As fast as images can be drawn, none left out: the stamps of a renderer have every number.
    let stamps: Subscriber<FrameStamp> = Subscriber::open(&bus, &FRAME_STAMP, "view-axial", 1024).unwrap();
    while stamps.next().unwrap().is_some() {}
    steer(&world, &["speed", "max"]);
    steer(&world, &["play"]);
    let mut seqs = Vec::new();
    crate::support::wait_for("60 images", || {
        let drawn = std::iter::from_fn(|| stamps.next().unwrap());
        // Where it begins anew, a view may say for a moment that there is no pose.
        seqs.extend(
            drawn
                .filter(|stamp| stamp.frame_state() == Some(FrameState::Live))
                .map(|stamp| stamp.seq),
        );
        (seqs.len() > 60).then_some(())
    });
    // What the recording itself lacks is nobody's loss here.
    let recorded: Vec<u64> = poses.iter().map(|pose| pose.seq).collect();
    let place = |seq: u64| recorded.iter().position(|&other| other == seq).unwrap();
    for pair in seqs.windows(2) {
        let (from, to) = (place(pair[0]), place(pair[1]));
        assert!(
            to == from + 1 || to == from || (from + 1 == recorded.len() && to == 0),
            "{pair:?}"
        );
    }
    drop((frames, held, renderer, stamps, moving, still, bus));
    assert!(pilot.stop().success());
    let report = crate::support::report(&world.path("again"));
    assert_eq!(
        (&report["replay"]["same_volume"], &report["problems"]),
        (&true.into(), &Value::Array(vec![]))
    );
    assert!(
        report["views"]
            .as_array()
            .unwrap()
            .iter()
            .all(|view| view["unflagged_old"] == 0)
    );
}

#[test]
fn what_cannot_be_done_is_refused_with_what_can() {
    let world = World::new();
    let scene = world.file("small.toml", SMALL);
    let live = world.start(&scene, &world.path("live"), "again");
    live.wait_live();
    let output = world.output("pilot", &["replay-control", "--run", "again", "pause"]);
    assert!(
        stderr(&output).contains("run \"again\" is not a replay"),
        "{}",
        stderr(&output)
    );
    assert!(live.stop().success());

    let recording = world.path("live").join("session.mcap");
    let pilot = start(&world, &recording, &["--loop", "--speed", "0.5"]);
    pilot.wait_for("every view replayed", |status| all_are(status, "replay", None));
    let output = world.output("pilot", &["replay-control", "--run", "again", "seek", "1h"]);
    assert!(
        stderr(&output).contains("there is no place 3600 s in this replay: it goes from 0.000 s to"),
        "{}",
        stderr(&output)
    );
    // A second replay under the same name.
    let (file, third) = (recording.to_string_lossy(), world.path("third"));
    let third = third.to_string_lossy();
    let again = ["replay", &*file, "--run", "again", "--out", &*third];
    let output = world.output("pilot", &again);
    assert!(
        stderr(&output).contains("run \"again\" is already going"),
        "{}",
        stderr(&output)
    );
    let ended = pilot.stop();
    assert!(
        ended.success(),
        "{}",
        crate::support::report(&world.path("again"))["problems"]
    );
}

#[test]
fn a_killed_replayer_is_followed_by_one_that_goes_on_where_it_was() {
    let world = World::new();
    let scene = world.file("small.toml", SMALL);
    world.navigate(&scene, &world.path("live"), &["--for", "3s"]);
    let recording = world.path("live").join("session.mcap");
    let published: Vec<_> = reader::poses(&recording, TOOL_POSE)
        .unwrap()
        .map(Result::unwrap)
        .map(|pose| (pose.seq, pose.t_publish_ns))
        .collect();
    let pilot = start(&world, &recording, &["--speed", "0.05"]);
    // The successor begins at the last pose that was published: at most one interval before the moment that was seen.
    let interval_s = published.windows(2).map(|pair| pair[1].1 - pair[0].1).max().unwrap() as f64 / 1e9;
    let status = pilot.wait_for("the middle", |status| at_s(status) > interval_s + 0.1);
    let (was_at_s, killed) = (at_s(&status), crate::support::pid_in(&status, "replay").unwrap());
    crate::support::kill_9(killed);
    let status = pilot.wait_for("its successor", |status| {
        let mut processes = status["processes"].as_array().unwrap().iter();
        let is_successor = |process: &Value| process["pid"] != killed && process["stage"] == "ready";
        processes.any(|process| process["name"] == "replay" && is_successor(process))
    });
    let successor_at_s = at_s(&status);
    assert!(
        successor_at_s >= was_at_s - interval_s,
        "{was_at_s} s, poses at most {interval_s} s apart: {status:#}"
    );
    steer(&world, &["speed", "max"]);
    crate::support::wait_for("the end of the replay", || (!is_going(&world)).then_some(()));
    let report = crate::support::report(&world.path("again"));
    assert_eq!(report["restarts"].as_array().unwrap().len(), 1, "{report:#}");
    assert_eq!(report["views"][0]["seq"], published.last().unwrap().0);
}

/// Right behind the beginning of another round, `pilot status` told of the last image of the round before with an age below zero.
#[test]
fn no_age_is_below_zero_where_a_replay_begins_anew() {
    let world = World::new();
    let scene = world.file("small.toml", SMALL);
    world.navigate(&scene, &world.path("live"), &["--for", "1s"]);
    let recording = world.path("live").join("session.mcap");
    let pilot = start(&world, &recording, &["--loop", "--from", "0.2s", "--to", "0.35s"]);
    pilot.wait_for("every view replayed", |status| all_are(status, "replay", None));
    let mut rounds = 0;
    let mut last_s = 0.0;
    crate::support::wait_for("twenty rounds", || {
        let status = pilot.status()?;
        let now_s = at_s(&status);
        rounds += u32::from(now_s < last_s);
        last_s = now_s;
        let ages = status["views"].as_array().unwrap().iter().map(|view| &view["age_ms"]);
        for age in ages.chain([&status["pose"]["age_ms"]]) {
            assert!(age.as_f64().is_none_or(|ms| ms >= 0.0), "{status:#}");
        }
        (rounds >= 20).then_some(())
    });
    let _ = pilot.stop();
}

fn at_s(status: &Value) -> f64 {
    status["replay"]["at_s"].as_f64().unwrap()
}

fn is_going(world: &World) -> bool {
    world.output("pilot", &["status", "--run", "again"]).status.success()
}
