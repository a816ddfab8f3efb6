//! A server's session with one client, driven by hand.

use igtl::session::{Action, Event, Notice, Reason, Server, ServerRules};
use igtl::{Body, Command, Kind, Message, Name, Pace, Query, Text, TypeName, Version};

use crate::support::{device, name, transform};

const MS: i64 = 1_000_000;

fn query(query: Query) -> Message<'static> {
    Message::new(device(), Body::Query(query))
}

fn pace(resolution_ms: u32) -> Pace {
    Pace {
        resolution_ms,
        frame: Name::EMPTY,
    }
}

fn rts(kind: Kind, status: u8, version: Version) -> Action {
    Action::Send(query(Query::Answer(kind, status)).in_version(version))
}

fn accepted() -> Server {
    Server::new(ServerRules::default(), 0)
}

fn received(server: &mut Server, message: &Message<'_>) -> Vec<Action> {
    server.step(Event::Received(message), 0)
}

#[test]
fn a_client_is_sent_one_until_it_speaks_two() {
    let mut server = accepted();
    assert_eq!(server.version(), Version::One);
    let start = query(Query::Start(Kind::Tdata, pace(50)));
    assert!(received(&mut server, &start).contains(&rts(Kind::Tdata, 0, Version::One)));
    let actions = received(&mut server, &start.clone().in_version(Version::Two));
    assert_eq!(actions[0], Action::Tell(Notice::SpeaksTwo));
    assert_eq!(actions[2], rts(Kind::Tdata, 0, Version::Two));
    // What is sent to a reader of version 1 has no metadata.
    let one = transform().in_version(Version::One);
    assert!(one.metadata.is_empty() && one.to_vec().is_ok());
}

#[test]
fn a_stream_comes_at_its_pace() {
    let mut server = accepted();
    assert!(!server.take_due(Kind::Tdata, 0));
    received(&mut server, &query(Query::Start(Kind::Tdata, pace(50))));
    let due: Vec<i64> = (0..200).filter(|ms| server.take_due(Kind::Tdata, ms * MS)).collect();
    assert_eq!(due, [0, 50, 100, 150]);
    assert!(!server.take_due(Kind::Qtdata, 0));
}

#[test]
fn a_second_start_takes_the_place_of_the_first() {
    let mut server = accepted();
    received(&mut server, &query(Query::Start(Kind::Tdata, pace(1000))));
    assert!(server.take_due(Kind::Tdata, 0) && !server.take_due(Kind::Tdata, MS));
    let actions = received(&mut server, &query(Query::Start(Kind::Tdata, pace(0))));
    let began = Notice::Began {
        kind: Kind::Tdata,
        pace: pace(0),
    };
    assert_eq!(actions, [Action::Tell(began), rts(Kind::Tdata, 0, Version::One)]);
    // An interval of 0: each that there is.
    assert!((1..9).all(|ms| server.take_due(Kind::Tdata, ms * MS)));
    assert_eq!(server.pace(Kind::Tdata), Some(pace(0)));
}

#[test]
fn what_is_not_had_or_never_comes_is_refused() {
    let mut server = accepted();
    for (kind, resolution) in [(Kind::Tdata, u32::MAX), (Kind::Tdata, 60_001), (Kind::Image, 0)] {
        let actions = received(&mut server, &query(Query::Start(kind, pace(resolution))));
        let refused = Notice::Refused {
            kind,
            pace: pace(resolution),
        };
        assert_eq!(actions, [Action::Tell(refused), rts(kind, 1, Version::One)]);
        assert_eq!(server.pace(kind), None);
    }
}

#[test]
fn a_stop_ends_a_stream_and_without_one_is_an_error() {
    let mut server = accepted();
    let stop = query(Query::Stop(Kind::Tdata));
    let none = [
        Action::Tell(Notice::NotBegun(Kind::Tdata)),
        rts(Kind::Tdata, 1, Version::One),
    ];
    assert_eq!(received(&mut server, &stop), none);
    received(&mut server, &query(Query::Start(Kind::Tdata, pace(0))));
    let ended = [
        Action::Tell(Notice::Ended(Kind::Tdata)),
        rts(Kind::Tdata, 0, Version::One),
    ];
    assert_eq!(received(&mut server, &stop), ended);
    assert!(!server.take_due(Kind::Tdata, 0));
    assert_eq!(received(&mut server, &stop), none);
}

#[test]
fn questions_and_commands_are_handed_on() {
    let mut server = accepted();
    let ask = Action::Answer {
        kind: Kind::Status,
        device: device(),
    };
    assert_eq!(received(&mut server, &query(Query::Get(Kind::Status))), [ask]);
    let command = Command {
        number: 9,
        name: name("Version"),
        content: Text::new(""),
    };
    let actions = received(&mut server, &Message::new(device(), Body::Command(command.clone())));
    assert_eq!(
        actions,
        [Action::Command {
            device: device(),
            command
        }]
    );
}

#[test]
fn an_answer_that_comes_first_is_told_and_no_more() {
    let mut server = accepted();
    let actions = received(&mut server, &query(Query::Answer(Kind::Tdata, 0)));
    assert_eq!(actions, [Action::Tell(Notice::NotAsked(Kind::Tdata))]);
}

#[test]
fn what_is_not_read_is_skipped_and_counted_up_to_a_bound() {
    let mut server = accepted();
    let other = |kind: &str| {
        let body = Body::Other {
            kind: name(kind),
            content: Vec::new().into(),
        };
        Message::new(device(), body)
    };
    for _ in 0..3 {
        let actions = received(&mut server, &other("VIDEO"));
        assert_eq!(actions, [Action::Tell(Notice::Skipped(name("VIDEO")))]);
    }
    // A question that this server does not answer is one of them.
    received(&mut server, &query(Query::Get(Kind::PolyData)));
    assert_eq!(server.skipped()[&name::<12>("VIDEO")], 3);
    assert_eq!(server.skipped()[&name::<12>("GET_POLYDATA")], 1);
    for number in 0..1000 {
        received(&mut server, &other(&format!("T{number}")));
    }
    assert_eq!(server.skipped().len(), 65);
    assert_eq!(server.skipped().values().sum::<u64>(), 1004);
    assert!(server.skipped()[&TypeName::EMPTY] > 900);
}

#[test]
fn a_client_may_say_nothing_but_not_half_a_message() {
    let mut server = accepted();
    assert_eq!(server.step(Event::Tick { come: 0 }, i64::MAX), []);
    let begun = Event::Tick { come: 57 };
    assert_eq!(server.step(begun, 0), []);
    assert_eq!(server.step(begun, 2000 * MS), []);
    let ns = 2000 * MS + 1;
    assert_eq!(server.step(begun, ns), [Action::Close(Reason::Stuck { come: 57, ns })]);
    received(
        &mut server,
        &query(Query::Start(Kind::Tdata, pace(0))).in_version(Version::Two),
    );
    server.step(Event::Closed, ns);
    assert_eq!((server.version(), server.pace(Kind::Tdata)), (Version::One, None));
}
