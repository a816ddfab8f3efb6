//! The client by hand: messages in, frames out.

mod deceived;
mod fuzzed;
mod kinds;
mod stamps;

use std::time::Duration;

use bus::message::Lost;
use geometry::Rigid;
use igtl::{Matrix, Metadata, Text, ToolKind, US_ASCII, Version};

use scene::localizer::StatusRule;

use super::*;
use crate::driver::{Frame, Seen};

const MS: i64 = 1_000_000;

fn spec(status: StatusRule) -> OpenIgtLinkSpec {
    OpenIgtLinkSpec {
        peer: Peer::Plus,
        status,
        stream: None,
        max_rotation_error: 2e-3,
        least_distance_mm: 10.0,
        reconnect: Reconnect::Always,
        silent: Duration::from_millis(1500),
        images: None,
    }
}

fn markers() -> PosedMarkers {
    PosedMarkers {
        marker: Some("StylusToTracker".to_owned()),
        marker_from_tool: Rigid::identity(),
        reference: Some(("ReferenceToTracker".to_owned(), Rigid::identity())),
        noise: None,
    }
}

fn client(status: StatusRule) -> OpenIgtLink {
    let mut client = OpenIgtLink::new(&spec(status), &markers()).unwrap();
    client.connected(0);
    client
}

fn stamp(ns: i64) -> Stamp {
    Stamp::of_ns(1_790_000_000_000_000_000 + ns.unsigned_abs()).unwrap()
}

fn at(x: f32) -> Matrix {
    Matrix {
        translation: [x, 0.0, -1500.0],
        ..Matrix::IDENTITY
    }
}

/// A TRANSFORM; without a status it is one of version 1.
fn transform(name: &str, at_ns: i64, x: f32, status: Option<&str>) -> Vec<u8> {
    let mut message = Message::new(DeviceName::new(name).unwrap(), Body::Transform(at(x)));
    message.stamp = stamp(at_ns);
    if let Some(status) = status {
        message.version = Version::Two;
        let text = Text {
            encoding: US_ASCII,
            bytes: status.as_bytes().to_vec(),
        };
        message.metadata = Metadata::EMPTY.with(igtl::TRANSFORM_STATUS, text);
    }
    message.to_vec().unwrap()
}

fn frames(acts: Vec<Act>) -> Vec<Frame> {
    let frame = |act| match act {
        Act::Frame(frame) => Some(frame),
        _ => None,
    };
    acts.into_iter().filter_map(frame).collect()
}

fn words(acts: &[Act]) -> Vec<&str> {
    let word = |act| match act {
        &Act::Tell(ref words) | &Act::Close(ref words) => Some(words.as_str()),
        _ => None,
    };
    acts.iter().filter_map(word).collect()
}

/// The place of each marker along x, or why there is none.
fn seen(frame: &Frame) -> Vec<(u32, Result<f64, Lost>)> {
    let x = |seen: &Seen| seen.outcome.map(|(pose, _)| pose.translation_mm()[0]);
    frame.seen.iter().map(|seen| (seen.marker, x(seen))).collect()
}

#[test]
fn tool_and_patient_of_one_stamp_are_one_frame() {
    let mut client = client(StatusRule::Required);
    let bytes = [
        transform("ReferenceToTracker", 0, 5.0, Some("OK")),
        transform("Other", 0, 9.0, Some("OK")),
        transform("StylusToTracker", 0, 7.0, Some("OK")),
    ]
    .concat();
    // Whatever the network makes of it.
    let mut acts = Vec::new();
    for piece in bytes.chunks(7) {
        acts.extend(client.bytes(piece, 3 * MS));
    }
    assert!(words(&acts).contains(&"the peer sends Other, which the scene does not name"));
    let frames = frames(acts);
    assert_eq!(frames.len(), 1);
    assert_eq!(seen(&frames[0]), [(1, Ok(5.0)), (0, Ok(7.0))]);
    assert_eq!(
        (frames[0].device_ns, frames[0].arrival_ns),
        (1_790_000_000_000_000_000, 3 * MS)
    );
    assert_eq!(client.words(), "version 2, not in the scene: Other");
}

#[test]
fn a_pose_without_a_status_counts_only_where_the_scene_says_so() {
    for (rule, expected) in [
        (StatusRule::Required, Err(Lost::Refused)),
        (StatusRule::AbsentMeansValid, Ok(7.0)),
    ] {
        let mut client = client(rule);
        client.bytes(&transform("ReferenceToTracker", 0, 5.0, Some("OK")), 0);
        let acts = client.bytes(&transform("StylusToTracker", 0, 7.0, None), 0);
        let told = words(&acts)
            .iter()
            .any(|words| words.contains("the peer states no status"));
        assert_eq!(told, expected.is_err());
        assert_eq!(seen(&frames(acts)[0])[1], (0, expected));
    }
}

#[test]
fn numbers_that_are_no_pose_are_refused_and_told_with_the_name_of_the_tool() {
    let mut client = client(StatusRule::Required);
    let mut message = Message::new(DeviceName::new("StylusToTracker").unwrap(), Body::Transform(at(1.0)));
    message = message.in_version(Version::Two);
    message.stamp = stamp(0);
    message.metadata = Metadata::EMPTY.with(
        igtl::TRANSFORM_STATUS,
        Text {
            encoding: US_ASCII,
            bytes: b"OK".to_vec(),
        },
    );
    let Body::Transform(matrix) = &mut message.body else {
        panic!()
    };
    matrix.columns[2] = [0.0, 0.0, -1.0];
    let acts = client.bytes(&message.to_vec().unwrap(), 0);
    assert_eq!(
        words(&acts),
        ["StylusToTracker: the matrix mirrors (determinant -1.000000)"]
    );
    assert!(acts.contains(&Act::Refused));
    let acts = client.tick(30 * MS);
    assert_eq!(seen(&frames(acts)[0]), [(0, Err(Lost::Refused))]);
}

#[test]
fn a_list_of_tools_is_of_one_instant_and_what_is_not_in_it_was_not_seen() {
    let mut client = client(StatusRule::Required);
    let tool = |name: &str, kind, x| igtl::Tool {
        name: DeviceName::new(name).unwrap(),
        kind,
        pose: at(x),
    };
    let tools = vec![
        tool("StylusToTracker", ToolKind::Five, 7.0),
        tool("ReferenceToTracker", ToolKind::Six, 5.0),
    ];
    let mut message = Message::new(DeviceName::EMPTY, Body::Tdata(tools)).in_version(Version::Two);
    message.stamp = stamp(0);
    for name in ["StylusToTracker", "ReferenceToTracker"] {
        let text = Text {
            encoding: US_ASCII,
            bytes: b"OK".to_vec(),
        };
        message.metadata = message.metadata.with(&format!("{name}Status"), text);
    }
    let acts = client.bytes(&message.to_vec().unwrap(), 0);
    assert!(
        words(&acts).iter().any(|words| words.contains("a tool of kind 5D")),
        "{acts:?}"
    );
    let found = frames(acts);
    assert_eq!(seen(&found[0]), [(0, Err(Lost::Refused)), (1, Ok(5.0))]);
}

/// The first list of two tools gave the pose of the first, before it was known that there are two.
#[test]
fn of_two_tools_in_the_first_list_neither_is_the_surgeons_where_the_scene_names_none() {
    let mut unnamed = markers();
    unnamed.marker = None;
    let mut client = OpenIgtLink::new(&spec(StatusRule::AbsentMeansValid), &unnamed).unwrap();
    client.connected(0);
    let tool = |name: &str, x| igtl::Tool {
        name: DeviceName::new(name).unwrap(),
        kind: ToolKind::Six,
        pose: at(x),
    };
    let tools = vec![tool("A", 1.0), tool("B", 2.0), tool("ReferenceToTracker", 5.0)];
    let bytes = Message::new(DeviceName::EMPTY, Body::Tdata(tools)).to_vec().unwrap();
    for _ in 0..2 {
        let acts = client.bytes(&bytes, 0);
        // The reference is named, and its pose is its own; without the tool's it is none of the tool.
        assert_eq!(seen(&frames(acts)[0])[0], (0, Err(Lost::Refused)));
    }
}

/// PLUS cuts the name of a tool at 20 bytes, and not the key of its status: a lost tool of a longer name counted as one without a status.
#[test]
fn the_status_of_a_long_name_is_found_by_the_whole_of_it() {
    let mut markers = markers();
    markers.marker = Some("StylusToTrackerOfTheRoom".to_owned());
    markers.reference = None;
    for (word, expected) in [("OK", Ok(7.0)), ("MISSING", Err(Lost::NotSeen))] {
        let mut client = OpenIgtLink::new(&spec(StatusRule::AbsentMeansValid), &markers).unwrap();
        client.connected(0);
        let name = DeviceName::new("StylusToTrackerOfThe").unwrap();
        let tool = igtl::Tool {
            name,
            kind: ToolKind::Six,
            pose: at(7.0),
        };
        let mut message = Message::new(DeviceName::EMPTY, Body::Tdata(vec![tool])).in_version(Version::Two);
        message.stamp = stamp(0);
        let bytes = word.as_bytes().to_vec();
        let text = Text {
            encoding: US_ASCII,
            bytes,
        };
        message.metadata = Metadata::EMPTY.with("StylusToTrackerOfTheRoomStatus", text);
        let acts = client.bytes(&message.to_vec().unwrap(), 0);
        assert_eq!(seen(&frames(acts)[0]), [(0, expected)]);
    }
}

#[test]
fn words_of_a_peer_steer_no_terminal() {
    let mut client = client(StatusRule::Required);
    let status = igtl::Status {
        code: 13,
        subcode: 0,
        name: DeviceName::new("Camera").unwrap(),
        words: b"not ready\x1b[2J".to_vec(),
    };
    let message = Message::new(DeviceName::EMPTY, Body::Status(status)).to_vec().unwrap();
    let acts = client.bytes(&message, 0);
    assert_eq!(words(&acts), ["the peer's STATUS is 13 Camera: not ready\\u{1b}[2J"]);
}

#[test]
fn a_peer_that_falls_silent_or_sends_no_messages_is_left() {
    let mut quiet = client(StatusRule::Required);
    let mut acts = Vec::new();
    for ms in 0..3000 {
        acts.extend(quiet.tick(ms * MS));
        if words(&acts).iter().any(|words| words.contains("nothing was heard")) {
            assert!((1500..1600).contains(&ms), "{ms}");
            break;
        }
    }
    assert!(matches!(acts.last(), Some(Act::Close(_))), "{acts:?}");
    let mut web = client(StatusRule::Required);
    let acts = web.bytes(
        b"HTTP/1.1 400 Bad Request\r\nServer: nginx\r\nContent-Type: text/html\r\n\r\n",
        0,
    );
    assert!(
        matches!(acts.last(), Some(Act::Close(why)) if why.contains("byte 0 of the connection")),
        "{acts:?}"
    );
}
