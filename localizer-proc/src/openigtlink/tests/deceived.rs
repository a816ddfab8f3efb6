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
    // On the next connection too, where the peer may speak version 1, which has no words for one: the lost tool was LIVE for good.
    client.closed(200 * MS);
    client.connected(200 * MS);
    let acts = client.bytes(&transform("StylusToTracker", 300 * MS, 7.0, None), 300 * MS);
    assert!(
        words(&acts)[0].contains("has stated one of this tool before"),
        "{acts:?}"
    );
    assert_eq!(client.wrong(), "StylusToTracker has no status any more");
    assert_eq!(seen(&frames(acts)[0]), [(0, Err(Lost::Refused))]);
}

/// A peer that was starting ended one connection at once: the next one was of version 1, where a lost tool is one without a status.
#[test]
fn a_peer_that_states_statuses_is_sent_version_2_after_a_connection_that_it_ended_at_once() {
    let spec = OpenIgtLinkSpec {
        peer: Peer::Auto,
        ..spec(StatusRule::AbsentMeansValid)
    };
    for has_spoken in [true, false] {
        let mut client = OpenIgtLink::new(&spec, &markers()).unwrap();
        client.connected(0);
        if has_spoken {
            client.bytes(&transform("StylusToTracker", 0, 7.0, Some("OK")), 0);
        }
        client.closed(1);
        client.connected(2);
        assert_eq!(client.closed(3), []);
        client.connected(4);
        assert!(client.words().starts_with("version 2"), "{}", client.words());
    }
}

/// The scene names no tool: the drill that was there after a connection had broken was the pointer of before.
#[test]
fn another_tool_after_a_connection_has_no_pose_where_the_scene_names_none() {
    let mut unnamed = markers();
    (unnamed.marker, unnamed.reference) = (None, None);
    let mut client = OpenIgtLink::new(&spec(StatusRule::Required), &unnamed).unwrap();
    for (k, (name, expected)) in [
        ("Pointer", Ok(7.0)),
        ("Pointer", Ok(7.0)),
        ("Drill", Err(Lost::Refused)),
    ]
    .iter()
    .enumerate()
    {
        let now_ns = 20 * MS * k as i64;
        client.connected(now_ns);
        let acts = client.bytes(&transform(name, now_ns, 7.0, Some("OK")), now_ns);
        assert_eq!(seen(&frames(acts)[0]), [(0, *expected)]);
        assert_eq!(
            client.words().contains("version 2, tool Pointer"),
            expected.is_ok(),
            "{}",
            client.words()
        );
        client.closed(now_ns);
    }
    assert_eq!(client.wrong(), "Drill is not Pointer");
}

/// Stamps of whole seconds at 25 Hz; the tool is seen at even instants and the patient at odd ones: the two were one frame now and then.
#[test]
fn tool_and_patient_of_two_instants_are_not_combined_where_stamps_are_coarse() {
    let mut client = client(StatusRule::Required);
    let (mut told, mut combined) = (Vec::new(), 0);
    for k in 0..1000_i64 {
        let (name, now_ns) = (["ReferenceToTracker", "StylusToTracker"][k as usize % 2], 40 * MS * k);
        let bytes = transform(name, now_ns / 1_000_000_000 * 1_000_000_000, k as f32, Some("OK"));
        let mut acts = client.bytes(&bytes, now_ns);
        acts.extend((1..10).flat_map(|ms| client.tick(now_ns + 4 * ms * MS)));
        told.extend(words(&acts).into_iter().map(str::to_owned));
        combined += frames(acts).iter().filter(|frame| frame.seen.len() > 1).count();
    }
    assert_eq!(combined, 0);
    assert_eq!(
        told.iter().filter(|words| words.contains("are not combined")).count(),
        1,
        "{told:?}"
    );
    assert_eq!(client.wrong(), "stamps do not tell instants apart");
}

/// One message said OK and the next one, of another kind and of the same stamp, MISSING: LIVE and LOST in turn.
#[test]
fn a_tool_that_is_seen_by_one_kind_of_message_and_lost_by_another_is_lost() {
    let mut client = alone("StylusToTracker", StatusRule::Required);
    let (mut told, mut good) = (Vec::new(), 0);
    for k in 0..100_i64 {
        let now_ns = 16 * MS * k;
        let mut list =
            Message::new(DeviceName::EMPTY, Body::Tdata(vec![tool("StylusToTracker", 7.0)])).in_version(Version::Two);
        list.stamp = stamp(now_ns);
        let (bytes, encoding) = (b"MISSING".to_vec(), US_ASCII);
        list.metadata = list.metadata.with("StylusToTrackerStatus", Text { encoding, bytes });
        let mut acts = client.bytes(&transform("StylusToTracker", now_ns, 7.0, Some("OK")), now_ns);
        acts.extend(client.bytes(&list.to_vec().unwrap(), now_ns + MS));
        told.extend(words(&acts).into_iter().map(str::to_owned));
        good += frames(acts)
            .iter()
            .filter(|frame| frame.seen[0].outcome.is_ok())
            .count();
    }
    assert_eq!(good, 1);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("is seen and that it is not"), "{told:?}");
    assert_eq!(client.wrong(), "StylusToTracker is seen and lost under one stamp");
}

/// The reason why there was no pose was in the log alone.
#[test]
fn the_newest_reason_of_a_refusal_is_what_is_wrong_while_it_is_so() {
    let mut client = alone("StylusToTracker", StatusRule::Required);
    assert_eq!(client.wrong(), "");
    client.bytes(&transform("Tool", 0, 7.0, Some("OK")), 0);
    client.bytes(&transform("Bone", 0, 7.0, Some("OK")), 0);
    assert_eq!(
        (client.wrong(), client.words()),
        ("2 not in the scene: Tool, Bone".to_owned(), "version 2".to_owned())
    );
    for (k, status, expected) in [
        (1, None, "StylusToTracker has no status"),
        (2, Some("INVALID"), "StylusToTracker states \"INVALID\""),
        (3, Some("MISSING"), "StylusToTracker states \"INVALID\""),
    ] {
        client.bytes(&transform("StylusToTracker", k * 20 * MS, 7.0, status), k * 20 * MS);
        assert_eq!(client.wrong(), expected);
    }
    client.tick(2100 * MS);
    assert_eq!(
        (client.wrong(), client.words()),
        (String::new(), "version 2, 2 not in the scene: Tool, Bone".to_owned())
    );
}

/// `transformStatus = MISSING` was no status at all, and valid where the scene says that an absent one is.
#[test]
fn a_status_under_a_key_that_is_nearly_right_is_no_good_pose() {
    let mut client = alone("StylusToTracker", StatusRule::AbsentMeansValid);
    let acts = client.bytes(
        &tdata(
            vec![tool("StylusToTracker", 7.0)],
            &[("stylusToTrackerStatus", "MISSING")],
        ),
        0,
    );
    assert!(
        words(&acts)[0].contains("\"stylusToTrackerStatus\" states what cannot be read"),
        "{acts:?}"
    );
    assert_eq!(seen(&frames(acts)[0]), [(0, Err(Lost::Refused))]);
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
