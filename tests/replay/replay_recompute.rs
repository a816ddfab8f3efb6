//! Poses made again from the emitters of a recorded session: with the same constants the same bits, with others what these
//! differ by, and nothing where it cannot be.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::support::links::{MARKER_FROM_TOOL_MM, register, tool_json};
use crate::support::{SMALL, World, stderr, stdout};
use bus::message::{ToolPose, Tracked};
use geometry::{Ct, Rigid, Tool, Vector};
use recorder::read::reader;
use recorder::read::scan::{self, Item};
use recorder::wire::schema::TOOL_POSE;
use serde_json::Value;

/// A room that is not quiet: frames are lost, late and out of order, a hand hides the marker for a while.
const ROOM: &str = "[tracker.room.marker]\ncone_deg = 60.0\n[tracker.room.hand]\nradius_mm = 90.0\nevery_s = 0.6\nfor_s = 0.2\n\
                    [tracker.room.localizer]\nacross_mm = 0.1\ndepth_mm = 0.15\nlatency_ms = 8.0\njitter_ms = 4.0\n\
                    dropped = 0.02\nlate = 0.05\nlate_ms = 40.0\n\
                    [tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n";

/// One small picture: every pose that is made again waits for those of all views, and these are not looked at here.
const ONE_VIEW: &str = "[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\nsize = [64, 64]\n";

/// The small scene with that view alone.
fn small() -> String {
    SMALL.split("[[views]]").next().unwrap().to_owned() + ONE_VIEW
}

/// A session of a second in that room, with a calibration from a file. The hand hides the marker every 0.6 s.
fn recorded(world: &World, more: &str) -> PathBuf {
    let tool = tool_json("mediastinoscope", "ball", MARKER_FROM_TOOL_MM);
    world.file("tool.json", &tool);
    let scene = small().replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n") + ROOM + more;
    let out = world.path("live");
    world.navigate(&world.file("room.toml", &scene), &out, &["--for", "1s"]);
    out.join("session.mcap")
}

fn recompute(world: &World, recording: &Path, out: &str, arguments: &[&str]) -> Output {
    let (recording, out) = (recording.to_string_lossy(), world.path(out));
    let out = out.to_string_lossy();
    let all = ["replay", &*recording, "--recompute", "--headless", "--out", &*out];
    world.output("pilot", &[&all[..], arguments].concat())
}

/// The same, where it must succeed; the new recording.
fn recomputed(world: &World, recording: &Path, out: &str, arguments: &[&str]) -> PathBuf {
    let output = recompute(world, recording, out, arguments);
    assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
    assert!(
        stdout(&output).contains("poses of the same number"),
        "{}",
        stdout(&output)
    );
    world.path(out).join("recomputed.mcap")
}

/// Every pose as it lies in the file, whole.
fn bytes(recording: &Path) -> Vec<Vec<u8>> {
    let messages = scan::open(recording).unwrap().filter_map(|item| match item.unwrap() {
        Item::Message(message) if message.channel.topic == TOOL_POSE => Some(message.data.into_owned()),
        _ => None,
    });
    messages.collect()
}

fn poses(recording: &Path) -> Vec<ToolPose> {
    reader::poses(recording, TOOL_POSE)
        .unwrap()
        .map(Result::unwrap)
        .collect()
}

fn valid(pose: &ToolPose) -> Option<Rigid<Ct, Tool>> {
    match pose.tracked().unwrap() {
        Tracked::Valid(at) => Some(at),
        Tracked::Lost(_) => None,
    }
}

fn json(path: PathBuf) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn with_the_same_constants_the_poses_are_the_same_bits() {
    let world = World::new();
    let recording = recorded(&world, "[tracker.smoothing]\ntime_constant_ms = 30.0\n");
    // What is used is the recording's own copy.
    fs::remove_file(world.path("tool.json")).unwrap();
    let again = recomputed(&world, &recording, "again", &[]);
    let (old, new) = (bytes(&recording), bytes(&again));
    assert!(old.len() > 10, "{}", old.len());
    assert_eq!(old.len(), new.len());
    let differing = old.iter().zip(&new).filter(|(old, new)| old != new).count();
    assert_eq!(differing, 0, "of {}", old.len());
    // Some were lost, and are lost again.
    let lost = poses(&recording).iter().filter(|pose| valid(pose).is_none()).count();
    assert!((1..old.len()).contains(&lost), "{lost} of {}", old.len());

    let out = world.path("again");
    let summary = json(out.join("compare.json"));
    assert_eq!(
        (&summary["common"], &summary["alone"]),
        (&old.len().into(), &serde_json::json!([0, 0]))
    );
    assert_eq!(summary["identical"], old.len() - lost);
    let report = crate::support::report(&out);
    assert_eq!(report["replay"]["recomputed"]["difference"], summary);
    assert_eq!(report["recording"], serde_json::json!(["recomputed.mcap"]));
    let account = json(out.join("replay.json"));
    assert_eq!(
        (&account["unanswered"], &account["without_frames"]),
        (&0.into(), &0.into())
    );
    assert!(out.join("compare.png").exists());
    let in_its_place = recompute(&world, &again, "again", &[]);
    let said = stderr(&in_its_place);
    assert!(said.contains("recomputed.mcap lies in the output folder"), "{said}");
    // Once more, over what is there, and out of the new recording.
    let moved = world.path("moved.mcap");
    fs::copy(&again, &moved).unwrap();
    let third = recomputed(&world, &moved, "again", &[]);
    assert!(bytes(&third) == old, "made again of what was made again, other poses");
}

#[test]
fn a_planted_shift_of_the_calibration_is_the_difference_of_the_tips() {
    let world = World::new();
    let recording = recorded(&world, "");
    let shift = [0.3, 0.0, -0.4];
    let tip: [f64; 3] = std::array::from_fn(|i| MARKER_FROM_TOOL_MM[i] + shift[i]);
    let shifted = world.file("shifted.json", &tool_json("mediastinoscope", "ball", tip));
    let again = recomputed(
        &world,
        &recording,
        "again",
        &["--calibration", shifted.to_str().unwrap()],
    );
    let (old, new) = (poses(&recording), poses(&again));
    assert_eq!(old.len(), new.len());
    let mut compared = 0;
    for (old, new) in old.iter().zip(&new) {
        assert_eq!((old.seq, old.t_publish_ns), (new.seq, new.t_publish_ns));
        let (Some(before), Some(after)) = (valid(old), valid(new)) else {
            continue;
        };
        // The marker's axes are the tool's here. Places of 2300 mm carry 4.5e-13 mm each, and go through some twenty
        // products on the way to the tip.
        let planted = (before * Vector::<Tool>::new(shift[0], shift[1], shift[2])).mm();
        let (before, after) = (before.translation_mm(), after.translation_mm());
        for i in 0..3 {
            assert!((after[i] - before[i] - planted[i]).abs() < 2e-11, "pose {}", old.seq);
        }
        assert_ne!(old.registration_id, new.registration_id);
        compared += 1;
    }
    assert!(compared > 5, "{compared}");
    let summary = json(world.path("again").join("compare.json"));
    assert_eq!(
        (&summary["compared"], &summary["valid_in_one"]),
        (&compared.into(), &serde_json::json!([0, 0]))
    );
    for key in ["rms", "p50", "p95", "max"] {
        assert!(
            (summary["tip_mm"][key].as_f64().unwrap() - 0.5).abs() < 1e-10,
            "{summary}"
        );
    }
    let table = fs::read_to_string(world.path("again").join("compare.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + old.len());
}

#[test]
fn another_registration_moves_every_tip_alike() {
    let world = World::new();
    let recording = recorded(&world, "");
    let hash = crate::support::report(&world.path("live"))["volume"]["hash"]
        .as_str()
        .unwrap()
        .to_owned();
    let first = world.path("first.json");
    register(&world, "tracker", &hash, &first);
    // The same pairs with the patient 5 mm further left.
    let pairs = fs::read_to_string(world.path("pairs.csv")).unwrap();
    let moved = pairs.lines().enumerate().map(|(i, line)| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if i > 0 {
            fields[3] = (fields[3].parse::<f64>().unwrap() + 5.0).to_string();
        }
        fields.join(",") + "\n"
    });
    let moved = world.file("moved.csv", &moved.collect::<String>());
    let second = world.path("second.json");
    let line = [
        "register",
        "--pairs",
        moved.to_str().unwrap(),
        "--to",
        "ct",
        "--from",
        "tracker",
        "--noise-mm",
        "0.2",
    ];
    let more = ["--ct-hash", &hash, "--out", second.to_str().unwrap()];
    let output = world.output("calib", &[&line[..], &more].concat());
    assert!(output.status.success(), "{}", stderr(&output));

    let with = |out: &str, file: &Path| {
        poses(&recomputed(
            &world,
            &recording,
            out,
            &["--registration", file.to_str().unwrap()],
        ))
    };
    let (first, second) = (with("a", &first), with("b", &second));
    let pairs = first
        .iter()
        .zip(&second)
        .filter_map(|(a, b)| Some((valid(a)?, valid(b)?)));
    let apart = |(a, b): (Rigid<Ct, Tool>, Rigid<Ct, Tool>)| {
        let (a, b) = (a.translation_mm(), b.translation_mm());
        [b[0] - a[0] - 5.0, b[1] - a[1], b[2] - a[2]]
    };
    let apart: Vec<[f64; 3]> = pairs.map(apart).collect();
    assert!(apart.len() > 5, "{}", apart.len());
    // Both registrations are fitted: roundings of places of 2300 mm, thrown once more as far as they lie from the points.
    assert!(apart.iter().flatten().all(|d| d.abs() < 1e-9), "{apart:?}");
}

#[test]
fn what_cannot_be_made_again_is_refused_by_name() {
    let world = World::new();
    let recording = recorded(&world, "");
    let is_refused = |output: &Output, words: &[&str]| {
        let said = stderr(output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(words.iter().all(|words| said.contains(words)), "{words:?} in: {said}");
        assert!(!world.path("again").join("recomputed.mcap").exists());
    };
    let pointer = world.file("pointer.json", &tool_json("pointer", "ball", MARKER_FROM_TOOL_MM));
    let output = recompute(
        &world,
        &recording,
        "again",
        &["--calibration", pointer.to_str().unwrap()],
    );
    is_refused(
        &output,
        &[
            "no pose can be made of the recorded emitters: pointer.json",
            "made for the tool \"pointer\", in use is \"mediastinoscope\"",
            "tracker could not be started",
        ],
    );
    let registration = world.path("other.json");
    register(&world, "tracker", &"ab".repeat(32), &registration);
    let output = recompute(
        &world,
        &recording,
        "again",
        &["--registration", registration.to_str().unwrap()],
    );
    is_refused(&output, &["other.json", "made for the CT \"abab"]);
    let output = recompute(&world, &recording, "again", &["--calibration", "nowhere.json"]);
    is_refused(
        &output,
        &[
            "--calibration nowhere.json: ",
            "give the path of a file that `calib` wrote",
        ],
    );
    let output = recompute(&world, &recording, "live", &[]);
    is_refused(&output, &["live holds a recorded session"]);

    let scene = world.file("small.toml", &small());
    world.navigate(&scene, &world.path("plain"), &["--for", "300ms"]);
    let output = recompute(&world, &world.path("plain").join("session.mcap"), "again", &[]);
    is_refused(&output, &["session.mcap holds no emitters (topic /emitters)"]);
}
