//! Through a network that misbehaves: what a client gets is what was published, or the connection ends.

use std::time::Duration;

use igtl::{Body, Message};
use serde_json::Value;

use crate::peers;
use crate::poses::assert_rows;
use crate::rig::{Raw, Rig};
use crate::support::proxy::{Fault, cut_step, through};

const PACE: Duration = Duration::from_millis(4);
/// Poses that are published to somebody whose network has fallen silent: 2 s, in which a client has long connected and read.
const SILENT_POSES: u64 = 500;

/// Every pose is one that was published, each newer than the one before; how many there were.
fn assert_poses(lines: &[String]) -> usize {
    let poses = lines.iter().filter(|line| line.starts_with("TRANSFORM "));
    let seqs: Vec<u64> = poses
        // A line that the end of the client cut off.
        .filter(|line| line.split_whitespace().count() == 16)
        .map(|line| assert_rows(&peers::numbers(line, 4)))
        .collect();
    assert!(seqs.is_sorted_by(|a, b| a < b), "{seqs:?}");
    seqs.len()
}

#[test]
fn what_comes_late_in_bytes_or_after_a_stall_is_what_was_published() {
    let Some(peer) = peers::cxx() else { return };
    let rig = Rig::new();
    let mut seq = 0;
    for fault in [
        Fault::Delay(Duration::from_millis(60)),
        Fault::BytesOfBoth,
        // In a header, and in a body.
        Fault::StallBehind(500, Duration::from_millis(300)),
        Fault::StallBehind(1111, Duration::from_millis(300)),
    ] {
        let address = through(fault, rig.address);
        let queries = ["listen", "120", "GET_STATUS", "GET_CAPABIL"];
        let mut child = peers::start(peer, address, &queries);
        seq = rig.poses_until(PACE, seq, Some(&mut child), u64::MAX);
        // It ends with an error where a CRC is wrong.
        let lines = peers::lines(child);
        assert_eq!(lines.len(), 120, "{fault:?}");
        assert!(assert_poses(&lines) > 60, "{fault:?} {lines:#?}");
        assert!(lines.iter().any(|line| line.starts_with("CAPABILITY")), "{fault:?}");
    }
}

#[test]
fn pyigtl_takes_what_was_published_late_in_bytes_and_after_a_stall() {
    let rig = Rig::new();
    let mut seq = 0;
    for fault in [
        Fault::Delay(Duration::from_millis(60)),
        Fault::BytesOfBoth,
        Fault::StallBehind(500, Duration::from_millis(300)),
    ] {
        let address = through(fault, rig.address);
        let Some(mut child) = peers::python(address, &["two", "20"]) else {
            return;
        };
        seq = rig.poses_until(PACE, seq, Some(&mut child), u64::MAX);
        peers::printed(child)
            .as_array()
            .unwrap()
            .iter()
            .for_each(assert_published);
    }
}

/// What pyigtl made of a pose is what was published with its number.
fn assert_published(message: &Value) {
    let rows = message["matrix"].as_array().unwrap()[..3].iter();
    let rows: Vec<f64> = rows
        .flat_map(|row| row.as_array().unwrap())
        .map(|n| n.as_f64().unwrap())
        .collect();
    let seq = assert_rows(&rows);
    assert_eq!(message["metadata"]["PoseNumber"], seq.to_string());
    assert_eq!(message["metadata"]["TransformStatus"], "OK");
}

/// A reader of pyigtl behind a network that is cut, or falls silent and says nothing: what it has read until then was published.
#[test]
fn pyigtl_has_read_nothing_that_was_not_published_where_its_network_ends() {
    let rig = Rig::new();
    let mut seq = 0;
    let cuts = (0..=1200).step_by(cut_step(157)).map(Fault::CutBehind);
    for fault in cuts.chain([500, 1111].map(Fault::SilentBehind)) {
        let Some(mut child) = peers::python(through(fault, rig.address), &["each", "500"]) else {
            return;
        };
        if let Fault::SilentBehind(_) = fault {
            // It would wait for ever.
            seq = rig.poses_until(PACE, seq, Some(&mut child), SILENT_POSES);
            child.kill().unwrap();
        }
        seq = rig.poses_until(PACE, seq, Some(&mut child), u64::MAX);
        let output = child.wait_with_output().unwrap();
        assert!(!output.status.success(), "{fault:?}: it read all of 500");
        let lines = String::from_utf8(output.stdout).unwrap();
        lines
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .for_each(|message: Value| assert_published(&message));
    }
}

fn number(message: &Message<'_>) -> Option<u64> {
    match &message.body {
        Body::Transform(matrix) => {
            let rows = matrix.rows().map(|row| row.map(f64::from));
            Some(assert_rows(&rows.concat()))
        }
        _ => None,
    }
}

/// Of a message that was cut off nothing is taken, wherever the cut is.
#[test]
fn a_connection_that_is_cut_at_any_byte_ends_with_whole_messages() {
    let rig = Rig::new();
    rig.pose(0);
    let mut seq = 1;
    for at in 0..320 {
        let mut client = Raw::dial(through(Fault::CutBehind(at), rig.address));
        let (mut bytes, mut last) = (0, None);
        // The end comes once so many bytes were sent: statuses and poses go on.
        while let Some(message) = client.next_while(|| {
            rig.pose(seq);
            seq += 1;
        }) {
            bytes += message.to_vec().unwrap().len();
            if let Some(seq) = number(&message) {
                assert!(last.is_none_or(|last| seq > last), "{seq} after {last:?}");
                last = Some(seq);
            }
        }
        assert!(bytes <= at, "{bytes} bytes of messages behind a cut at {at}");
    }
    rig.wait_for_note(|note| note.contains(": 0 clients"));
}

#[test]
fn a_cxx_client_that_is_cut_off_has_read_nothing_that_was_not_published() {
    let Some(peer) = peers::cxx() else { return };
    let rig = Rig::new();
    let mut seq = 0;
    let places: Vec<usize> = match cut_step(0) {
        0 => vec![1, 57, 58, 59, 100, 3000, 3031, 3062, 3093, 3124],
        _ => (0..320).chain(3000..3125).collect(),
    };
    let silent = [500, 3031].map(Fault::SilentBehind);
    for fault in places.into_iter().map(Fault::CutBehind).chain(silent) {
        let mut child = peers::start(peer, through(fault, rig.address), &["listen", "500"]);
        if let Fault::SilentBehind(_) = fault {
            // It would wait for ever.
            seq = rig.poses_until(PACE, seq, Some(&mut child), SILENT_POSES);
            child.kill().unwrap();
        }
        seq = rig.poses_until(PACE, seq, Some(&mut child), u64::MAX);
        let output = child.wait_with_output().unwrap();
        let lines: Vec<String> = String::from_utf8_lossy(&output.stdout)
            .lines()
            .map(str::to_owned)
            .collect();
        let poses = assert_poses(&lines);
        let is_early = matches!(fault, Fault::CutBehind(..3000) | Fault::SilentBehind(_));
        assert!(is_early || poses > 5, "{fault:?} {lines:#?}");
    }
}

/// Whoever is behind a network that has fallen silent is closed, and costs nobody else anything.
#[test]
fn a_connection_that_falls_silent_half_open_is_closed_alone() {
    let rig = Rig::new();
    let mut lost = Raw::dial(through(Fault::SilentBehind(1000), rig.address));
    let mut other = rig.client();
    rig.wait_for_note(|note| note.contains("2 clients"));
    let mut seq = 0;
    loop {
        rig.pose(seq);
        other.wait_for("each pose", |message| number(message).filter(|got| *got == seq));
        seq += 1;
        if seq.is_multiple_of(10) && rig.wait_for_note(|_| true).contains("1 clients, 1 dropped") {
            break;
        }
        assert!(seq < 10_000, "it is still there");
        std::thread::sleep(PACE);
    }
    // What came through before is right.
    lost.wait_for("a pose", number);
}
