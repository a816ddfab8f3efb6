//! What peers that are not ours read of poses, and of poses that are none.

use std::time::Duration;

use bus::message::{Lost, ToolPose, Tracked, Workflow};
use geometry::{Point, Tool};
use igtl::{Body, DeviceName, Kind, Matrix, Message, Query, Status, Text, ToolStatus, Version};

use crate::peers;
use crate::rig::{Rig, SCENE, place};

const PACE: Duration = Duration::from_millis(16);

/// The rows of `ToolToRas` for a pose, from the places that points of the tool have in the patient: nothing of the product is used but
/// the pose itself. The tool's own frame is turned too.
fn expected(seq: u64) -> [f64; 12] {
    let at = |x: f64, y: f64, z: f64| {
        let [x, y, z] = (place(seq) * Point::<Tool>::new(-x, -y, z)).mm();
        [-x, -y, z]
    };
    let origin = at(0.0, 0.0, 0.0);
    let axes = [at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0)];
    let mut rows = [0.0; 12];
    for row in 0..3 {
        for column in 0..3 {
            rows[4 * row + column] = axes[column][row] - origin[row];
        }
        rows[4 * row + 3] = origin[row];
    }
    rows
}

/// Which pose has these rows; each differs from every other by 0.25 mm.
fn which(rows: &[f64]) -> u64 {
    let seq = ((-rows[3] - 40.0) / 0.25).round();
    assert!(seq >= 0.0, "{rows:?}");
    seq as u64
}

/// Fails where the rows are those of no pose that a rig publishes; which one it is.
pub(crate) fn assert_rows(rows: &[f64]) -> u64 {
    let seq = which(rows);
    let off = rows
        .iter()
        .zip(expected(seq))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    // Rounding to single precision: 2^-24 of at most 150 mm; and the differences of places above, 1e-13.
    assert!(off <= 9e-6, "pose {seq} is off by {off}: {rows:?}");
    seq
}

#[test]
fn a_cxx_client_reads_every_pose_as_it_was_published() {
    let Some(peer) = peers::cxx() else { return };
    let rig = Rig::new();
    let mut child = peers::start(peer, rig.address, &["listen", "100"]);
    rig.poses_until(PACE, 0, Some(&mut child), 100_000);
    let lines = peers::lines(child);
    let poses: Vec<&String> = lines.iter().filter(|line| line.starts_with("TRANSFORM")).collect();
    assert!(poses.len() > 60, "{lines:#?}");
    let seqs: Vec<u64> = poses.iter().map(|line| assert_rows(&peers::numbers(line, 4))).collect();
    assert!(seqs.is_sorted_by(|a, b| a < b), "{seqs:?}");
    for line in &poses {
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[1], "ToolToRas");
        // The stamp is that of the capture, by the wall clock.
        let (stamp, now): (f64, f64) = (words[2].parse().unwrap(), words[3].parse().unwrap());
        let late_s = now / 1e9 - stamp;
        assert!((-0.001..1.0).contains(&late_s), "{line}");
    }
    let state = |line: &&String| line.starts_with("STATUS Trocar") && line.contains(" 1 LIVE|LIVE");
    assert!(lines.iter().any(|line| state(&line)), "{lines:#?}");
}

#[test]
fn pyigtl_takes_poses_in_version_1_and_metadata_once_it_speaks_2() {
    let rig = Rig::new();
    let Some(mut child) = peers::python(rig.address, &["poses", "20"]) else {
        return;
    };
    let next = rig.poses_until(PACE, 0, Some(&mut child), 100_000);
    let found = peers::printed(child);
    for message in found.as_array().unwrap() {
        let rows = message["matrix"].as_array().unwrap()[..3].iter();
        let rows: Vec<f64> = rows
            .flat_map(|row| row.as_array().unwrap())
            .map(|n| n.as_f64().unwrap())
            .collect();
        assert_rows(&rows);
        assert_eq!(message["version"], 1);
    }
    let mut child = peers::python(rig.address, &["two", "20"]).unwrap();
    rig.poses_until(PACE, next, Some(&mut child), 100_000);
    for message in peers::printed(child).as_array().unwrap() {
        assert_eq!(message["metadata"]["TransformStatus"], "OK");
        assert_eq!(message["metadata"]["SessionStatus"], "SIMULATED TRACKER");
        let rows = message["matrix"].as_array().unwrap()[..3].iter();
        let rows: Vec<f64> = rows
            .flat_map(|row| row.as_array().unwrap())
            .map(|n| n.as_f64().unwrap())
            .collect();
        let seq = assert_rows(&rows);
        assert_eq!(message["metadata"]["PoseNumber"], seq.to_string());
    }
}

pub(crate) fn get(kind: Kind, version: Version) -> Message<'static> {
    Message::new(DeviceName::EMPTY, Body::Query(Query::Get(kind))).in_version(version)
}

/// What is said of a transform: whether it may be believed, and its numbers.
pub(crate) fn transform(message: &Message<'_>) -> Option<(ToolStatus, Matrix, String)> {
    let Body::Transform(matrix) = message.body else {
        return None;
    };
    let why = message.metadata.get("TransformStatusReason").map(Text::to_string);
    Some((
        ToolStatus::of_transform(&message.metadata),
        matrix,
        why.unwrap_or_default(),
    ))
}

#[test]
fn a_lost_pose_is_never_ok_and_says_why_to_clients_of_both_versions() {
    let rig = Rig::new();
    let (mut one, mut two) = (rig.client(), rig.client());
    two.send(&get(Kind::Status, Version::Two));
    for (seq, reason) in (0..).step_by(2).zip(Lost::ALL) {
        rig.pose(seq);
        let seen = two.wait_for("a pose", |message| {
            transform(message).filter(|(status, ..)| status.is_ok())
        });
        assert_eq!(seen.1.translation[0], -(40.0 + 0.25 * seq as f32));
        one.wait_for("the pose", transform);
        rig.lost(seq + 1, reason);
        let (status, matrix, why) = two.wait_for("a lost pose", |message| {
            transform(message).filter(|(status, ..)| !status.is_ok())
        });
        assert_eq!(
            (status, why),
            (ToolStatus::Missing, format!("LOST: {}", reason.words()))
        );
        // No number of it is one that a tool could have.
        assert!(igtl::rotation::check(&matrix.columns, 0.5).is_err() && matrix.translation == [0.0; 3]);
        // A client that reads no metadata is sent words, and no matrix.
        one.wait_for("why there is none", |message| {
            assert!(transform(message).is_none(), "{message:?}");
            assert_eq!(message.version, Version::One);
            match &message.body {
                // A beat of before, on its way while poses were written, says what held then.
                Body::Status(status) if status.code != Status::OK => {
                    let words = String::from_utf8(status.words.clone()).unwrap();
                    let is_it = words.starts_with(&format!("LOST: {}", reason.words()));
                    assert!(
                        is_it || words.starts_with("WITHHELD: the run has not said yet"),
                        "{words}"
                    );
                    is_it.then_some(())
                }
                _ => None,
            }
        });
    }
}

#[test]
fn a_pose_that_stands_still_in_time_or_place_ends_and_is_not_answered_as_valid() {
    // The same numbers for longer than half a second are no measurement.
    let rig = Rig::new();
    let mut two = rig.client();
    two.send(&get(Kind::Status, Version::Two));
    let mut seq = 0;
    let frozen = loop {
        let mut sample = ToolPose {
            seq,
            t_capture_ns: rig.now_ns(),
            ..ToolPose::EMPTY
        };
        sample.set(Tracked::Valid(place(7)));
        rig.tool.send(sample).unwrap();
        seq += 1;
        let (status, _, why) = two.wait_for("a transform", transform);
        if why.contains("FROZEN") {
            break status;
        }
        assert!(seq < 2000);
        std::thread::sleep(Duration::from_millis(5));
    };
    assert_eq!(frozen, ToolStatus::Missing);
    rig.pose(seq + 1);
    two.wait_for("a pose", |message| {
        transform(message).filter(|(status, ..)| status.is_ok())
    });
    // Nothing comes any more: stale after 100 ms, silent after a second.
    for word in ["STALE", "LOST: tracker silent"] {
        two.wait_for(word, |message| {
            let (status, _, why) = transform(message)?;
            assert!(!status.is_ok());
            why.starts_with(word).then_some(())
        });
    }
    for version in [Version::One, Version::Two] {
        let mut late = rig.client();
        late.send(&get(Kind::Transform, version));
        late.send(&get(Kind::Capability, version));
        late.wait_for("the answers", |message| {
            assert!(
                transform(message).is_none_or(|(status, ..)| !status.is_ok()),
                "{message:?}"
            );
            matches!(message.body, Body::Capability(_)).then_some(())
        });
    }
}

#[test]
fn what_the_workflow_does_not_let_be_shown_is_withheld() {
    let rig = Rig::new();
    let mut two = rig.client();
    two.send(&get(Kind::Status, Version::Two));
    rig.pose(0);
    two.wait_for("a pose", |message| {
        transform(message).filter(|(status, ..)| status.is_ok())
    });
    rig.may(Workflow::BUMPED);
    rig.pose(1);
    let (_, _, why) = two.wait_for("no pose", |message| {
        transform(message).filter(|(status, ..)| !status.is_ok())
    });
    assert_eq!(why, "WITHHELD: the marker on the patient was pushed");
    // Who comes now is told it too.
    let said = rig.client().wait_for("the stage", |message| match &message.body {
        Body::String(text) if message.device == "Workflow" => {
            Some(text.to_string()).filter(|text| text.contains("BUMPED"))
        }
        _ => None,
    });
    assert_eq!(said, "NAVIGATING; REFERENCE BUMPED; SIMULATED TRACKER");
}

#[test]
fn a_replay_looks_like_the_present_to_no_client() {
    let rig = Rig::of(SCENE, Rig::replayed);
    let (mut one, mut two) = (rig.client(), rig.client());
    two.send(&get(Kind::Status, Version::Two));
    for client in [&mut one, &mut two] {
        // The clock of the replay stands at 0 here, and so does the pose's capture.
        let mut sample = ToolPose::EMPTY;
        sample.set(Tracked::Valid(place(3)));
        rig.tool.send(sample).unwrap();
        let (device, session) = client.wait_for("a pose", |message| {
            let is_said = transform(message).is_some_and(|(_, matrix, _)| matrix.translation != [0.0; 3]);
            let session = message.metadata.get("SessionStatus").map(Text::to_string);
            is_said.then_some((message.device.to_string(), session))
        });
        assert_eq!(device, "ReplayToolToRas");
        assert!(session.is_none_or(|session| session == "REPLAY, NOT LIVE"));
        client.wait_for("the status", |message| match &message.body {
            Body::Status(status) => {
                assert_ne!(status.code, Status::OK);
                let words = String::from_utf8_lossy(&status.words).into_owned();
                assert!(
                    words.contains("REPLAY, NOT LIVE") && !words.starts_with("LIVE"),
                    "{words}"
                );
                words.starts_with("VALID").then_some(())
            }
            _ => None,
        });
    }
}
