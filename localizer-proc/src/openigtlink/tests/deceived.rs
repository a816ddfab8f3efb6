//! Peers that say what is not so: each test is an input for which a wrong pose was shown once, or a wrong word told.

use super::*;

fn tool(name: &str, x: f32) -> igtl::Tool<Matrix> {
    igtl::Tool {
        name: DeviceName::new(name).unwrap(),
        kind: ToolKind::Six,
        pose: at(x),
    }
}

/// A TDATA with these statuses.
fn tdata(tools: Vec<igtl::Tool<Matrix>>, statuses: &[(&str, &str)]) -> Vec<u8> {
    let mut message = Message::new(DeviceName::EMPTY, Body::Tdata(tools)).in_version(Version::Two);
    message.stamp = stamp(0);
    for (key, word) in statuses {
        let bytes = word.as_bytes().to_vec();
        let encoding = US_ASCII;
        message.metadata = message.metadata.with(key, Text { encoding, bytes });
    }
    message.to_vec().unwrap()
}

fn alone(name: &str, rule: StatusRule) -> OpenIgtLink {
    let mut markers = markers();
    markers.marker = Some(name.to_owned());
    markers.reference = None;
    let mut client = OpenIgtLink::new(&spec(rule), &markers).unwrap();
    client.connected(0);
    client
}

/// A peer cuts two names at the same 20 bytes and sends both tools: the surgeon's was now here, now there, and always valid.
#[test]
fn two_tools_with_one_name_have_no_pose() {
    for rule in [StatusRule::Required, StatusRule::AbsentMeansValid] {
        let mut client = client(rule);
        let mut told = Vec::new();
        let mut all = Vec::new();
        for i in 0..20_i64 {
            for (name, x) in [
                ("StylusToTracker", 7.0),
                ("StylusToTracker", 300.0),
                ("ReferenceToTracker", 5.0),
            ] {
                let acts = client.bytes(&transform(name, i * 20 * MS, x, Some("OK")), i * 20 * MS);
                told.extend(words(&acts).into_iter().map(str::to_owned));
                all.extend(frames(acts));
            }
        }
        let tools = all.iter().flat_map(seen).filter(|(marker, _)| *marker == 0);
        let places: Vec<Result<f64, Lost>> = tools.map(|(_, place)| place).collect();
        assert!(
            places.len() >= 20 && places.iter().all(|place| *place == Err(Lost::Refused)),
            "{places:?}"
        );
        assert_eq!(
            told.iter()
                .filter(|words| words.contains("two tools with one name"))
                .count(),
            1,
            "{told:?}"
        );
    }
}

/// One tool under stamps that stand still for a while, or are coarse, moves as hands move.
#[test]
fn one_tool_that_moves_under_one_stamp_is_not_taken_for_two() {
    let mut client = alone("StylusToTracker", StatusRule::Required);
    for i in 0..100_i64 {
        // 1 m/s, 100 Hz, stamps of 15.6 ms.
        let stamp_ns = i * 10 * MS / 15_600_000 * 15_600_000;
        let bytes = transform("StylusToTracker", stamp_ns, 10.0 * i as f32, Some("OK"));
        for frame in frames(client.bytes(&bytes, i * 10 * MS)) {
            assert_eq!(seen(&frame), [(0, Ok(10.0 * i as f64))]);
        }
    }
}

/// A lost tool counted as seen where its peer states a status in some messages and leaves it out of others.
#[test]
fn who_has_stated_a_status_is_not_believed_without_one() {
    let mut client = alone("StylusToTracker", StatusRule::AbsentMeansValid);
    for (i, (word, expected)) in [
        (None, Ok(7.0)),
        (Some("MISSING"), Err(Lost::NotSeen)),
        (None, Err(Lost::Refused)),
        (Some("OK"), Ok(7.0)),
        (None, Err(Lost::Refused)),
    ]
    .into_iter()
    .enumerate()
    {
        let now_ns = 20 * MS * i as i64;
        let acts = client.bytes(&transform("StylusToTracker", now_ns, 7.0, word), now_ns);
        assert_eq!(seen(&frames(acts)[0]), [(0, expected)], "{i}");
    }
    client.closed(0);
    client.connected(0);
    let acts = client.bytes(&transform("StylusToTracker", 0, 7.0, None), 0);
    assert_eq!(seen(&frames(acts)[0]), [(0, Ok(7.0))]);
}

/// The status of a long name stands under the whole of it, and another tool's of the same 20 bytes was no status at all: valid, where the
/// scene says that an absent one is.
#[test]
fn the_status_of_another_tool_of_the_same_name_is_no_good_pose() {
    const CUT: &str = "StylusToTrackerOfThe";
    for (statuses, expected) in [
        (&[("StylusToTrackerOfTheHallStatus", "MISSING")][..], Err(Lost::Refused)),
        (&[("StylusToTrackerOfTheHallStatus", "OK")], Err(Lost::Refused)),
        (
            &[
                ("StylusToTrackerOfTheRoomStatus", "OK"),
                ("StylusToTrackerOfTheHallStatus", "MISSING"),
            ],
            Err(Lost::Refused),
        ),
        (&[("StylusToTrackerOfTheStatus", "MISSING")], Err(Lost::NotSeen)),
        (&[("StylusToTrackerOfTheStatus", "OK")], Ok(7.0)),
        (
            &[("StylusToTrackerOfTheRoomStatus", "OK"), ("OtherStatus", "MISSING")],
            Ok(7.0),
        ),
    ] {
        let mut client = alone("StylusToTrackerOfTheRoom", StatusRule::AbsentMeansValid);
        let acts = client.bytes(&tdata(vec![tool(CUT, 7.0)], statuses), 0);
        assert_eq!(seen(&frames(acts)[0]), [(0, expected)], "{statuses:?}");
    }
}

/// With `reconnect = "ask"` a server of version 1 was never reached: the connection that showed its version was the last.
#[test]
fn the_connection_that_shows_the_version_is_followed_by_one_that_uses_it() {
    let spec = OpenIgtLinkSpec {
        peer: Peer::Auto,
        reconnect: Reconnect::Ask,
        ..spec(StatusRule::AbsentMeansValid)
    };
    let mut client = OpenIgtLink::new(&spec, &markers()).unwrap();
    client.connected(0);
    let acts = client.tick(1100 * MS);
    assert!(
        words(&acts)
            .iter()
            .any(|words| words.contains("no whole message within 1.0 s")),
        "{acts:?}"
    );
    client.closed(1100 * MS);
    assert!(client.reconnects());
    client.connected(1200 * MS);
    assert!(!client.reconnects());
    client.bytes(&transform("StylusToTracker", 0, 7.0, None), 1300 * MS);
    client.closed(1400 * MS);
    assert!(!client.reconnects());
}

/// The words of a STATUS may have thousands of characters, and stood in the log whole.
#[test]
fn long_words_of_a_peer_are_cut() {
    let mut client = client(StatusRule::Required);
    let status = igtl::Status {
        code: 13,
        subcode: 0,
        name: DeviceName::new("Camera").unwrap(),
        words: vec![b'x'; 30_000],
    };
    let message = Message::new(DeviceName::EMPTY, Body::Status(status)).to_vec().unwrap();
    let acts = client.bytes(&message, 0);
    assert!(words(&acts).iter().all(|words| words.len() < 300));
}

/// A proper rotation with a place in metres was a good pose a hair from the localizer, and so was the identity of what was never measured.
#[test]
fn a_place_in_metres_is_refused_with_its_distance_and_what_is_allowed() {
    let mut client = alone("StylusToTracker", StatusRule::AbsentMeansValid);
    let mut told = Vec::new();
    let placed = [
        ([0.1, 0.06, 0.11], false),
        ([0.0; 3], false),
        ([-1.9, 0.4, -3.2], false),
        ([-6.0, 6.0, 6.0], true),
        ([100.0, 60.0, 110.0], true),
    ];
    for (k, (translation, is_pose)) in (1..).zip(placed) {
        let matrix = Matrix {
            translation,
            ..Matrix::IDENTITY
        };
        let mut message = Message::new(DeviceName::new("StylusToTracker").unwrap(), Body::Transform(matrix));
        message.stamp = stamp(k * 20 * MS);
        let acts = client.bytes(&message.to_vec().unwrap(), k * 20 * MS);
        told.extend(words(&acts).into_iter().map(str::to_owned));
        let frames = frames(acts);
        let outcome = frames[0].seen[0].outcome;
        assert_eq!(outcome.is_ok(), is_pose, "{translation:?}: {outcome:?}");
        assert!(is_pose || outcome == Err(Lost::Refused), "{translation:?}");
    }
    assert!(
        told[0].contains("0 mm from the localizer's origin") && told[0].contains("least_distance_mm allows 10 mm"),
        "{told:?}"
    );
}
