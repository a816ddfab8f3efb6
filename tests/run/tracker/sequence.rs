//! Recorded sequences as a source of poses: what was invalid when it was recorded is lost when it is played.

#![allow(clippy::print_stdout, reason = "why a test was skipped")]

use std::collections::BTreeMap;
use std::path::Path;

use crate::support::{SMALL, World};
use bus::message::{Lost, ToolPose, Tracked};
use geometry::{Ct, Point, Tool};
use recorder::read::reader;
use recorder::wire::schema::TOOL_POSE;

fn scene(tables: &str) -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"sequence\"\n") + tables
}

/// Plays a scene; returns its poses by number, and the report.
fn played(world: &World, tables: &str, length: &str) -> (BTreeMap<u64, ToolPose>, serde_json::Value) {
    let (scene, out) = (world.file("s.toml", &scene(tables)), world.path("out"));
    let report = world.navigate(&scene, &out, &["--for", length]);
    let poses = reader::poses(&out.join("session.mcap"), TOOL_POSE).unwrap();
    (
        poses.map(|pose| pose.unwrap()).map(|pose| (pose.seq, pose)).collect(),
        report,
    )
}

/// A sequence of 160 frames at 50 Hz that moves along x; frames 120 to 124 are invalid, 130 repeats a time, 140 goes back.
/// Before them is time for a busy machine to start the tracker, which begins with the next frame.
fn sequence() -> String {
    let mut text = "ObjectType = Image\n".to_owned();
    for i in 0..160 {
        let t = match i {
            130 => 102.58,
            140 => 102.3,
            _ => 100.0 + 0.02 * f64::from(i),
        };
        let status = if (120..125).contains(&i) { "INVALID" } else { "OK" };
        text += &format!(
            "Seq_Frame{i:04}_ToolToTrackerTransform = 1 0 0 {i} 0 1 0 6 0 0 1 7 0 0 0 1\n\
             Seq_Frame{i:04}_ToolToTrackerTransformStatus = {status}\nSeq_Frame{i:04}_Timestamp = {t}\n"
        );
    }
    text + "ElementDataFile = LOCAL\n"
}

#[test]
fn a_sequence_is_played_at_its_times_and_what_is_invalid_is_lost() {
    let world = World::new();
    world.file("a.mha", &sequence());
    let tables = "[tracker.sequence]\nfile = \"a.mha\"\nnoise_mm = 0.1\n[tracker.smoothing]\ntime_constant_ms = 35\n";
    let (poses, report) = played(&world, tables, "6s");
    let (&first, pose) = poses.first_key_value().unwrap();
    assert!(first < 120, "{first}");
    // Frames 130 and 140 have no time of their own.
    let numbers: Vec<u64> = (first..160).filter(|seq| *seq != 130 && *seq != 140).collect();
    assert!(poses.keys().eq(&numbers), "{:?}", poses.keys());
    let start = pose.t_capture_ns - 20_000_000 * first as i64;
    let mut last = None;
    for (seq, pose) in &poses {
        let seq = *seq as i64;
        let from_start_ns = pose.t_capture_ns - start;
        // Stamps of 100 s carry 1.4e-14 s, which nanoseconds round away to 1.
        assert!((from_start_ns - 20_000_000 * seq).abs() <= 1, "{seq}: {from_start_ns}");
        assert!((pose.t_device_ns - 100_000_000_000 - from_start_ns).abs() <= 1);
        match pose.tracked().unwrap() {
            Tracked::Lost(lost) => assert!(lost == Lost::NotSeen && (120..125).contains(&seq), "{seq}: {lost:?}"),
            Tracked::Valid(at) => {
                let x = at.translation_mm()[0];
                assert!(!(120..125).contains(&seq));
                // Smoothed, it lags behind, but not right after it was lost.
                assert!(x <= seq as f64 && (seq != 125 || x == 125.0), "{seq}: {x}");
                assert!(last.is_none_or(|last| x > last));
                assert_eq!((pose.delay_ns, pose.tip_95_mm()), (35_000_000, None));
                last = Some(x);
            }
        }
    }
    let accuracy = &report["accuracy"];
    assert_eq!(accuracy["lost"], serde_json::json!({ "marker not seen": 5 }));
    assert_eq!(accuracy["smoothing_delay_ms"], 35.0);
}

#[test]
fn in_simulated_time_every_frame_is_played_up_to_the_end_of_the_run() {
    let world = World::new();
    world.file("a.mha", &sequence());
    let scene = world.file("s.toml", &scene("[tracker.sequence]\nfile = \"a.mha\"\n"));
    let out = world.path("out");
    world.navigate(&scene, &out, &["--for", "3s", "--speed", "max"]);
    let poses = reader::poses(&out.join("session.mcap"), TOOL_POSE).unwrap();
    let numbers: Vec<u64> = poses.map(|pose| pose.unwrap().seq).collect();
    // Frame 150 is 3 s behind the first; frames 130 and 140 have no time of their own.
    let expected: Vec<u64> = (0..150).filter(|seq| *seq != 130 && *seq != 140).collect();
    assert_eq!(numbers, expected);
}

#[test]
fn a_recording_of_plus_is_played_with_its_reference() {
    let Some(file) = crate::support::shared("data/tracker-plus/TransformInterpolationTest.igs.mha") else {
        return;
    };
    let world = World::new();
    let tables = format!(
        "[tracker.sequence]\nfile = {file:?}\nmarker = \"ProbeToTracker\"\nreference = \"ReferenceToTracker\"\n\
         [tracker.sequence.ct_from_reference]\ntranslation_mm = [10.0, 20.0, 30.0]\n"
    );
    let (poses, _) = played(&world, &tables, "4s");
    let (&number, pose) = poses.first_key_value().unwrap();
    assert!(poses.len() > 40, "{number}");
    // Frame 7 is marked INVALID; a process that a busy machine starts late begins with the next frame.
    let lost: Vec<u64> = poses
        .values()
        .filter(|pose| pose.status != 0)
        .map(|pose| pose.seq)
        .collect();
    assert_eq!(lost, if number <= 7 { vec![7] } else { vec![] });
    let pose = if number == 7 { &poses[&8] } else { pose };
    let Tracked::Valid(at) = pose.tracked().unwrap() else {
        panic!("frame {} is OK", pose.seq)
    };
    let expected = expected(&file, pose.seq);
    // Six digits of 1500 mm, of both matrices, and what rounding them to rotations turns at that distance.
    let tip = Point::<Tool>::new(0.0, 0.0, 0.0);
    assert!((at * tip).distance(expected) < 0.05, "{:?} {expected:?}", at * tip);
}

/// Where the probe of a frame is: by its matrices, with the transpose for the inverse.
fn expected(file: &Path, frame: u64) -> Point<Ct> {
    let text = String::from_utf8_lossy(&std::fs::read(file).unwrap()).into_owned();
    let matrix = |name: &str| -> Vec<f64> {
        let line = text
            .lines()
            .find(|line| line.starts_with(&format!("Seq_Frame{frame:04}_{name}Transform =")))
            .unwrap();
        line.split('=')
            .nth(1)
            .unwrap()
            .split_whitespace()
            .map(|n| n.parse().unwrap())
            .collect()
    };
    let (probe, reference) = (matrix("ProbeToTracker"), matrix("ReferenceToTracker"));
    let off = [3, 7, 11].map(|i| probe[i] - reference[i]);
    let [x, y, z] = [0, 1, 2].map(|c| (0..3).map(|r| reference[4 * r + c] * off[r]).sum::<f64>());
    Point::new(10.0 + x, 20.0 + y, 30.0 + z)
}

#[test]
fn a_sequence_that_cannot_be_played_is_refused_before_the_run_begins() {
    let room = crate::support::room::Room::new();
    let refused = |text: &str, tables: &str, words: &str| {
        room.file("a.mha", text);
        let scene = room.file("s.toml", &scene(tables));
        room.run_is_refused(&scene, &[], words);
    };
    let file = "[tracker.sequence]\nfile = \"a.mha\"\n";
    refused("nothing\n", file, "tracker-proc: | a.mha | no line ElementDataFile");
    let other = format!("{file}marker = \"Probe\"\n");
    refused(&sequence(), &other, "there is no transform Probe; found ToolToTracker");
    let bad = sequence().replace("1 0 0 3 0", "1 0 0 x 0");
    refused(&bad, file, "column 7 (a 4 x 4 matrix): found \"x\"");
    let timeless = sequence().replace("Seq_Frame0003_Timestamp", "Seq_Frame0003_Other");
    refused(&timeless, file, "frame 3 has no time stamp");
    refused(
        &sequence(),
        "[tracker.sequence]\nfile = \"b.mha\"\n",
        "b.mha: No such file",
    );
}
