//! A client's session, driven by hand.

use igtl::session::{Action, Ask, Client, ClientRules, Event, Notice, Reason, Speaks};
use igtl::{Body, DeviceName, Kind, Limits, Message, Pace, Query, Version, decode};

use crate::support::{framed, name, raw, transform};

const MS: i64 = 1_000_000;
const SECOND: i64 = 1000 * MS;

fn rules(speaks: Speaks) -> ClientRules {
    let pace = Pace {
        resolution_ms: 16,
        frame: name("Reference"),
    };
    let ask = |kind, pace| Ask {
        device: DeviceName::EMPTY,
        kind,
        pace,
    };
    ClientRules {
        speaks,
        asks: vec![ask(Kind::Tdata, Some(pace)), ask(Kind::Capability, None)],
        ..ClientRules::default()
    }
}

/// The types that are sent, with their versions.
fn sent(actions: &[Action]) -> Vec<(String, Version)> {
    let messages = actions.iter().filter_map(|action| match action {
        Action::Send(message) => Some((message.body.kind().to_string(), message.version)),
        _ => None,
    });
    messages.collect()
}

fn told(actions: &[Action]) -> Vec<Notice> {
    let notices = actions.iter().filter_map(|action| match action {
        Action::Tell(notice) => Some(notice.clone()),
        _ => None,
    });
    notices.collect()
}

fn answer(kind: Kind, status: u8) -> Message<'static> {
    Message::new(DeviceName::EMPTY, Body::Query(Query::Answer(kind, status)))
}

fn tick(client: &mut Client, now: i64) -> Vec<Action> {
    client.step(Event::Tick { come: 0 }, now)
}

#[test]
fn it_asks_on_connecting_in_the_version_of_its_peer() {
    for (speaks, version) in [
        (Speaks::Two, Version::Two),
        (Speaks::Auto, Version::Two),
        (Speaks::One, Version::One),
        (Speaks::Follow, Version::One),
    ] {
        let mut client = Client::new(rules(speaks));
        let actions = client.step(Event::Connected, 0);
        let expected = [("STT_TDATA", version), ("GET_CAPABIL", version)];
        assert_eq!(
            sent(&actions),
            expected.map(|(kind, version)| (kind.to_owned(), version))
        );
        let farewell = client.farewell();
        assert_eq!((farewell.len(), farewell[0].body.kind()), (1, name("STP_TDATA")));
    }
}

#[test]
fn a_client_that_asks_for_nothing_still_says_which_version_it_reads() {
    let mut client = Client::new(ClientRules {
        speaks: Speaks::Two,
        ..ClientRules::default()
    });
    let actions = client.step(Event::Connected, 0);
    assert_eq!(sent(&actions), [("GET_STATUS".to_owned(), Version::Two)]);
}

#[test]
fn answers_are_waited_for_as_long_as_is_said() {
    let mut client = Client::new(rules(Speaks::One));
    client.step(Event::Connected, 0);
    assert_eq!(told(&tick(&mut client, SECOND)), []);
    let late = told(&tick(&mut client, SECOND + 1));
    let unanswered = |kind| Notice::Unanswered { kind, limit_ns: SECOND };
    assert_eq!(late, [unanswered(Kind::Tdata), unanswered(Kind::Capability)]);
    assert_eq!(told(&tick(&mut client, SECOND + 2)), []);
    // One that comes all the same is told.
    let actions = client.step(Event::Received(&answer(Kind::Tdata, 0)), SECOND + 3);
    assert_eq!(told(&actions), [Notice::NotAsked(Kind::Tdata)]);
}

#[test]
fn answers_in_time_are_taken_and_refusals_told() {
    let mut client = Client::new(rules(Speaks::One));
    client.step(Event::Connected, 0);
    let capability = Message::new(DeviceName::EMPTY, Body::Capability(Vec::new()));
    assert_eq!(client.step(Event::Received(&capability), MS), []);
    let actions = client.step(Event::Received(&answer(Kind::Tdata, 1)), MS);
    let refused = Notice::RefusedByPeer {
        kind: Kind::Tdata,
        status: 1,
    };
    assert_eq!(told(&actions), [refused]);
    assert_eq!(told(&tick(&mut client, 2 * SECOND)), []);
}

#[test]
fn an_answer_before_any_question_is_told_and_no_more() {
    let mut client = Client::new(ClientRules::default());
    client.step(Event::Connected, 0);
    let actions = client.step(Event::Received(&answer(Kind::Tdata, 0)), 0);
    assert_eq!(actions, [Action::Tell(Notice::NotAsked(Kind::Tdata))]);
}

#[test]
fn it_follows_a_peer_that_speaks_two() {
    let mut client = Client::new(rules(Speaks::Follow));
    client.step(Event::Connected, 0);
    let actions = client.step(Event::Received(&transform()), MS);
    assert_eq!(told(&actions), [Notice::SpeaksTwo]);
    assert_eq!(
        sent(&tick(&mut client, SECOND)),
        [("GET_STATUS".to_owned(), Version::Two)]
    );
    // A new connection may be to another server.
    client.step(Event::Connected, 2 * SECOND);
    assert_eq!(client.version(), Version::One);
    let mut stubborn = Client::new(rules(Speaks::One));
    stubborn.step(Event::Connected, 0);
    assert_eq!(stubborn.step(Event::Received(&transform()), MS), []);
    assert_eq!(stubborn.version(), Version::One);
}

#[test]
fn a_server_that_falls_silent_after_two_is_sent_one_from_then_on() {
    let mut client = Client::new(rules(Speaks::Auto));
    client.step(Event::Connected, 0);
    assert!(
        !tick(&mut client, SECOND)
            .iter()
            .any(|action| matches!(action, Action::Close(_)))
    );
    let actions = tick(&mut client, SECOND + 1);
    let closed = Action::Close(Reason::NotVersionTwo { ns: SECOND });
    assert_eq!(actions, [Action::Tell(Notice::FellBack), closed]);
    for connection in 2..5 {
        let actions = client.step(Event::Connected, connection * 10 * SECOND);
        assert!(sent(&actions).iter().all(|(_, version)| *version == Version::One));
    }
    // One that answers is sent version 2 for ever; a connection that breaks says nothing then.
    let mut client = Client::new(rules(Speaks::Auto));
    client.step(Event::Connected, 0);
    client.step(
        Event::Received(&answer(Kind::Tdata, 0).in_version(Version::Two)),
        SECOND / 2,
    );
    tick(&mut client, 2 * SECOND);
    client.step(Event::Closed, 3 * SECOND);
    client.step(Event::Connected, 20 * SECOND);
    assert_eq!(client.version(), Version::Two);
}

#[test]
fn a_server_that_spoke_one_before_it_fell_silent_is_sent_one_too() {
    let mut client = Client::new(rules(Speaks::Auto));
    client.step(Event::Connected, 0);
    client.step(Event::Received(&transform().in_version(Version::One)), MS);
    let ns = 3 * SECOND + 1;
    assert_eq!(tick(&mut client, MS + ns), [Action::Close(Reason::Silent { ns })]);
    let told = told(&client.step(Event::Closed, 4 * SECOND));
    assert_eq!(told, [Notice::NoneOfTwo]);
    client.step(Event::Connected, 5 * SECOND);
    assert_eq!(client.version(), Version::One);
}

#[test]
fn a_server_that_answers_neither_version_is_tried_with_both_again() {
    let mut client = Client::new(rules(Speaks::Auto));
    let mut versions = Vec::new();
    for connection in 0..4 {
        client.step(Event::Connected, connection * 2 * SECOND);
        versions.push(client.version());
        let told = told(&client.step(Event::Closed, connection * 2 * SECOND + SECOND));
        assert_eq!(told.contains(&Notice::NoneOfTwo), client.version() == Version::Two);
    }
    assert_eq!(versions, [Version::Two, Version::One, Version::Two, Version::One]);
    // One that answers version 1 is sent it for ever.
    for connection in 5..8 {
        client.step(Event::Connected, connection * 2 * SECOND);
        if client.version() == Version::One {
            client.step(Event::Received(&answer(Kind::Tdata, 0)), connection * 2 * SECOND);
        }
        client.step(Event::Closed, connection * 2 * SECOND + SECOND);
    }
    for connection in 16..20 {
        client.step(Event::Connected, connection * SECOND);
        assert_eq!(client.version(), Version::One);
        client.step(Event::Received(&answer(Kind::Tdata, 0)), connection * SECOND);
        client.step(Event::Closed, connection * SECOND + MS);
    }
}

/// A peer that was starting took one connection and ended it at once. From then on it was sent version 1, and stated no status any more.
#[test]
fn one_connection_that_ended_at_once_did_not_make_a_peer_one_of_version_1() {
    let mut client = Client::new(rules(Speaks::Auto));
    for connection in 0..5 {
        client.step(Event::Connected, connection * SECOND);
        assert_eq!(client.version(), Version::Two);
        assert_eq!(told(&client.step(Event::Closed, connection * SECOND + MS)), []);
    }
}

/// A peer that had spoken version 2 was sent version 1 once it was silent at the beginning of a connection, or ended it.
#[test]
fn who_has_spoken_version_2_was_never_sent_version_1_again() {
    let mut client = Client::new(rules(Speaks::Auto));
    client.step(Event::Connected, 0);
    client.step(Event::Received(&transform().in_version(Version::Two)), MS);
    client.step(Event::Closed, 2 * SECOND);
    for connection in 1..4 {
        let began = connection * 10 * SECOND;
        client.step(Event::Connected, began);
        assert_eq!(client.version(), Version::Two);
        let actions = tick(&mut client, began + 2 * SECOND);
        assert!(!actions.iter().any(|action| matches!(action, Action::Close(_))));
        let ns = 3 * SECOND + 1;
        let silent = Action::Close(Reason::Silent { ns });
        assert_eq!(tick(&mut client, began + ns), [silent]);
        assert_eq!(told(&client.step(Event::Closed, began + ns)), []);
    }
}

#[test]
fn silence_closes_and_heartbeats_go_out_meanwhile() {
    let mut client = Client::new(rules(Speaks::One));
    client.step(Event::Connected, 0);
    let mut beats = 0;
    for now in (100 * MS..=3 * SECOND).step_by(100_000_000) {
        let actions = tick(&mut client, now);
        beats += sent(&actions).len();
        assert!(!actions.iter().any(|action| matches!(action, Action::Close(_))));
    }
    assert_eq!(beats, 3);
    let ns = 3 * SECOND + 1;
    assert_eq!(tick(&mut client, ns), [Action::Close(Reason::Silent { ns })]);
}

#[test]
fn a_peer_that_sends_a_byte_now_and_then_is_closed() {
    let mut client = Client::new(rules(Speaks::One));
    client.step(Event::Connected, 0);
    client.step(Event::Received(&answer(Kind::Tdata, 0)), SECOND);
    for (come, at) in [(1, SECOND), (2, 2 * SECOND), (3, 3 * SECOND)] {
        let actions = client.step(Event::Tick { come }, at);
        assert!(!actions.iter().any(|action| matches!(action, Action::Close(_))));
    }
    let ns = 2 * SECOND + 1;
    let actions = client.step(Event::Tick { come: 4 }, SECOND + ns);
    assert_eq!(actions, [Action::Close(Reason::Stuck { come: 4, ns })]);
}

#[test]
fn a_volume_may_take_its_time_and_is_no_silence() {
    let mut client = Client::new(rules(Speaks::One));
    client.step(Event::Connected, 0);
    let a_tenth = |ms: u64| Event::Tick { come: 1 + ms * 70 };
    for ms in (0..60_000).step_by(100) {
        let actions = client.step(a_tenth(ms), ms as i64 * MS);
        assert!(
            !actions.iter().any(|action| matches!(action, Action::Close(_))),
            "{ms}: {actions:?}"
        );
    }
    // At less than 64 KiB/s it is held up.
    let actions = client.step(Event::Tick { come: 60_000 * 65 }, 60_000 * MS);
    assert!(matches!(actions[..], [Action::Close(Reason::Stuck { .. })]));
}

#[test]
fn three_refused_messages_in_a_row_close_and_one_that_cannot_go_on_does() {
    let mut bytes = raw("TRANSFORM", &[0; 48]);
    bytes[50] ^= 1;
    let crc = decode(&bytes, &Limits::default()).unwrap_err();
    let mut client = Client::new(rules(Speaks::One));
    client.step(Event::Connected, 0);
    let refused = Event::Refused(&crc);
    for _ in 0..2 {
        assert_eq!(client.step(refused, MS), [Action::Tell(Notice::Malformed(crc.clone()))]);
    }
    client.step(Event::Received(&transform()), MS);
    for _ in 0..2 {
        client.step(refused, MS);
    }
    let closed = Reason::TooManyRefused {
        count: 3,
        last: crc.clone(),
    };
    assert_eq!(client.step(refused, MS), [Action::Close(closed)]);
    let version = decode(&framed(3, b"X", b"", b""), &Limits::default()).unwrap_err();
    let actions = client.step(Event::Refused(&version), MS);
    assert_eq!(actions, [Action::Close(Reason::Malformed(version.clone()))]);
}
