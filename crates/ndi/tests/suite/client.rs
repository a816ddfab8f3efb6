//! A client's session, driven by hand.

use ndi::session::{Action, Client, ClientRules, DeviceRules, Event, Notice, Reason, Tool};
use ndi::{Command, ErrorCode, FrameStep, Handle, text_reply};

use crate::support::{MS, Pair, frame, rom, rules, tool};

fn sent(actions: &[Action]) -> Vec<String> {
    let sent = actions.iter().filter_map(|action| match action {
        Action::Send(bytes) => Some(String::from_utf8(bytes.clone()).unwrap()),
        _ => None,
    });
    sent.collect()
}

#[test]
fn it_begins_with_init_and_a_crc_or_without_one() {
    let mut client = Client::new(ClientRules::default());
    assert_eq!(sent(&client.step(Event::Connected, 0)), ["INIT:E3A5\r"]);
    let mut plain = Client::new(ClientRules {
        crc: false,
        ..ClientRules::default()
    });
    assert_eq!(sent(&plain.step(Event::Connected, 0)), ["INIT \r"]);
}

#[test]
fn a_serial_line_changes_its_speed_once_the_device_has_agreed() {
    let mut client = Client::new(ClientRules {
        comm: Some("50001".to_owned()),
        ..ClientRules::default()
    });
    client.step(Event::Connected, 0);
    let actions = client.step(Event::Bytes(b"OKAYA896\r"), MS);
    assert_eq!(
        sent(&actions),
        [String::from_utf8(Command::Comm("50001".to_owned()).to_bytes(true)).unwrap()]
    );
    let actions = client.step(Event::Bytes(b"OKAYA896\r"), 2 * MS);
    assert_eq!(actions[0], Action::Speed("50001".to_owned()));
    assert!(sent(&actions)[0].starts_with("VER:4"));
}

#[test]
fn a_refused_step_closes_with_its_command() {
    let mut client = Client::new(rules());
    client.step(Event::Connected, 0);
    for answer in ["OKAY", "a Device", "00"] {
        client.step(Event::Bytes(&text_reply(answer)), MS);
    }
    let actions = client.step(Event::Bytes(&text_reply("ERROR2D")), MS);
    let (command, error) = ("PHRQ *********1****".to_owned(), ErrorCode::HANDLES_FULL);
    assert_eq!(actions, [Action::Close(Reason::Refused { command, error })]);
    assert_eq!(client.step(Event::Bytes(&text_reply("OKAY")), MS), []);
    assert_eq!(client.step(Event::Tick, 100 * MS), []);
}

#[test]
fn a_warning_is_told_and_gone_on_from() {
    let mut client = Client::new(ClientRules::default());
    client.step(Event::Connected, 0);
    let actions = client.step(Event::Bytes(&text_reply("WARNING01")), MS);
    let warning = Notice::Warning {
        command: "INIT".to_owned(),
        code: Some(1),
    };
    assert_eq!(actions[0], Action::Tell(warning));
    assert_eq!(sent(&actions).len(), 1);
}

#[test]
fn too_many_tools_are_refused_before_anything_is_sent() {
    let tool = Tool {
        name: "one".to_owned(),
        rom: rom(),
        priority: 'D',
    };
    let mut client = Client::new(ClientRules {
        tools: vec![tool; 25],
        ..ClientRules::default()
    });
    let closed = Action::Close(Reason::TooManyTools { found: 25, most: 24 });
    assert_eq!(client.step(Event::Connected, 0), [closed]);
}

#[test]
fn a_device_that_still_tracks_is_stopped_first() {
    let mut client = Client::new(ClientRules::default());
    client.step(Event::Connected, 0);
    let actions = client.step(Event::Bytes(&text_reply("ERROR0C")), MS);
    assert!(sent(&actions)[0].starts_with("TSTOP"));
    let actions = client.step(Event::Bytes(&text_reply("OKAY")), MS);
    assert!(sent(&actions)[0].starts_with("INIT"));
}

#[test]
fn one_handle_for_two_tools_is_not_written_to() {
    let mut client = Client::new(rules());
    client.step(Event::Connected, 0);
    let answers = [&["OKAY", "a Device", "00", "01"][..], &["OKAY"; 14], &["01"]].concat();
    let mut actions = Vec::new();
    for answer in answers {
        actions = client.step(Event::Bytes(&text_reply(answer)), MS);
    }
    assert_eq!(actions, [Action::Tell(Notice::HandleTwice(Handle(1)))]);
}

#[test]
fn handles_of_before_are_freed() {
    let mut client = Client::new(ClientRules::default());
    client.step(Event::Connected, 0);
    for answer in ["OKAY", "a Device"] {
        client.step(Event::Bytes(&text_reply(answer)), MS);
    }
    let mut freed = Vec::new();
    let mut actions = client.step(Event::Bytes(&text_reply("0203001040FF")), MS);
    while sent(&actions)[0].starts_with("PHF") {
        freed.extend(sent(&actions));
        actions = client.step(Event::Bytes(&text_reply("OKAY")), MS);
    }
    assert_eq!(freed.len(), 2);
    assert!(freed[0].starts_with("PHF:03") && freed[1].starts_with("PHF:04"));
}

#[test]
fn frames_jump_and_follow_with_their_steps_and_those_of_before_are_not_given() {
    let mut pair = Pair::new(rules(), DeviceRules::default());
    pair.event(Event::Connected);
    let mut steps = Vec::new();
    for number in [5, 6, 9, 4_000_000_000, 3, 4_000_000_001] {
        pair.device.show(frame(number, vec![tool(1, 0)]));
        pair.now += 10 * MS;
        let actions = pair.client.step(Event::Tick, pair.now);
        let replies = pair.take(actions);
        for action in pair.client.step(Event::Bytes(&replies), pair.now) {
            if let Action::Publish(frame, step) = action {
                assert_eq!(frame.tool(Handle(2)).unwrap().why(), ndi::Why::NotInFrame);
                steps.push(step);
            }
        }
    }
    let next = |missed| FrameStep::Next { missed, wrapped: false };
    let jump = |from, to| FrameStep::Jump { from, to };
    assert_eq!(
        steps,
        [FrameStep::First, next(0), next(2), jump(9, 4_000_000_000), next(0)]
    );
}
