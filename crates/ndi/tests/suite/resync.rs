//! Late replies, resets, devices that say nothing or too much.

use ndi::session::{Action, Client, ClientRules, DeviceRules, Event, Notice, Reason};
use ndi::{ErrorCode, Fault, Handle, text_reply};

use crate::support::{MS, Pair, frame, rules, tool};

fn tracking() -> Pair {
    let mut pair = Pair::new(rules(), DeviceRules::default());
    pair.event(Event::Connected);
    pair.show(frame(1, vec![tool(1, 0), tool(2, 0)]));
    pair
}

/// Asks for a frame and keeps the device's answer back.
fn kept_back(pair: &mut Pair) -> Vec<u8> {
    pair.now += 10 * MS;
    let actions = pair.client.step(Event::Tick, pair.now);
    let replies = pair.take(actions);
    assert!(!replies.is_empty());
    replies
}

fn last_number(pair: &Pair) -> Option<u32> {
    pair.published.last().and_then(|frame| frame.number)
}

#[test]
fn a_late_reply_shifts_nothing() {
    let mut pair = tracking();
    pair.device.show(frame(2, vec![tool(1, 0)]));
    let late = kept_back(&mut pair);
    pair.wait(1100);
    let unanswered = |notice: &&Notice| matches!(notice, Notice::Unanswered { .. });
    assert_eq!(pair.told.iter().filter(unanswered).count(), 1);
    // It comes in the silence: it is dropped, and the silence begins anew.
    pair.event(Event::Bytes(&late));
    assert_eq!(last_number(&pair), Some(1));
    pair.wait(190);
    assert!(!pair.client.is_tracking());
    pair.wait(100);
    assert!(pair.client.is_tracking());
    assert!(pair.told.contains(&Notice::InStep { tries: 1 }));
    pair.show(frame(3, vec![tool(1, 0)]));
    assert_eq!(last_number(&pair), Some(3));
}

#[test]
fn a_reply_that_is_later_than_the_silence_is_not_the_answer_to_ver() {
    let mut pair = tracking();
    pair.device.show(frame(2, vec![tool(1, 0)]));
    let late = kept_back(&mut pair);
    // Until VER is asked, whose answer is kept back too.
    let mut answer = Vec::new();
    while answer.is_empty() {
        pair.now += 10 * MS;
        let actions = pair.client.step(Event::Tick, pair.now);
        answer = pair.take(actions);
    }
    pair.event(Event::Bytes(&late));
    let not_an_answer = |notice: &Notice| matches!(notice, Notice::NotAnAnswer { command } if command == "VER 4");
    assert!(pair.told.iter().any(not_an_answer));
    pair.event(Event::Bytes(&answer));
    pair.wait(300);
    assert!(pair.told.contains(&Notice::InStep { tries: 2 }));
    pair.show(frame(3, vec![tool(1, 0)]));
    assert_eq!(last_number(&pair), Some(3));
}

#[test]
fn a_late_reply_in_the_set_up_begins_it_anew() {
    let mut pair = Pair::new(rules(), DeviceRules::default());
    let actions = pair.client.step(Event::Connected, 0);
    let late = pair.take(actions);
    pair.wait(10_010);
    pair.event(Event::Bytes(&late));
    pair.wait(400);
    assert!(pair.client.is_tracking(), "{:?}", pair.told);
    pair.show(frame(3, vec![tool(1, 0)]));
    assert!(pair.published.last().unwrap().tool(Handle(1)).unwrap().pose().is_ok());
}

#[test]
fn a_reset_that_nobody_asked_for_sets_up_again() {
    let mut pair = tracking();
    let reset = pair.device.reset();
    pair.event(Event::Bytes(&reset));
    assert!(pair.told.contains(&Notice::Reset));
    assert!(pair.client.is_tracking());
    pair.show(frame(2, vec![tool(1, 0), tool(2, 0)]));
    assert!(pair.published.last().unwrap().tool(Handle(2)).unwrap().pose().is_ok());
    // One that was not heard shows in what polls are answered.
    drop(pair.device.reset());
    pair.wait(50);
    let refused = |notice: &Notice| {
        matches!(
            notice,
            Notice::Refused {
                error: ErrorCode::SYSTEM_NOT_INITIALIZED,
                ..
            }
        )
    };
    assert!(pair.told.iter().any(refused));
    assert!(pair.client.is_tracking());
}

#[test]
fn an_error_in_the_middle_of_a_reply_is_told_and_polling_goes_on() {
    let mut pair = tracking();
    pair.device.show(frame(2, vec![tool(1, 0)]));
    let whole = kept_back(&mut pair);
    let broken = [&whole[..30], &text_reply("ERROR1A")].concat();
    pair.event(Event::Bytes(&broken));
    pair.wait(1500);
    let inside =
        |notice: &Notice| matches!(notice, Notice::Malformed(m) if m.fault == Fault::ErrorInside { code: 0x1A });
    assert!(pair.told.iter().any(inside), "{:?}", pair.told);
    pair.show(frame(3, vec![tool(1, 0)]));
    assert_eq!(last_number(&pair), Some(3));
}

#[test]
fn a_damaged_reply_gives_no_frame() {
    let mut pair = tracking();
    pair.device.show(frame(2, vec![tool(1, 0)]));
    let mut damaged = kept_back(&mut pair);
    damaged[40] ^= 4;
    pair.event(Event::Bytes(&damaged));
    assert_eq!(last_number(&pair), Some(1));
    pair.wait(300);
    pair.show(frame(3, vec![tool(1, 0)]));
    assert_eq!(last_number(&pair), Some(3));
}

#[test]
fn one_byte_at_a_time_is_the_same() {
    let mut pair = tracking();
    pair.device.show(frame(2, vec![tool(1, 0), tool(2, 0x10D)]));
    let whole = kept_back(&mut pair);
    let mut together = pair.client.clone();
    let expected = together.step(Event::Bytes(&whole), pair.now);
    let mut actions = Vec::new();
    for byte in &whole {
        actions.extend(pair.client.step(Event::Bytes(&[*byte]), pair.now));
    }
    assert_eq!(actions, expected);
}

#[test]
fn a_silent_device_is_given_up() {
    let mut client = Client::new(ClientRules::default());
    client.step(Event::Connected, 0);
    let mut closed = None;
    for ms in (0..60_000).step_by(10) {
        for action in client.step(Event::Tick, ms * MS) {
            if let Action::Close(reason) = action {
                closed = Some((reason, ms));
            }
        }
    }
    let (reason, ms) = closed.unwrap();
    assert_eq!(reason, Reason::NoAnswer { tries: 3 });
    assert!((13_000..15_000).contains(&ms), "{ms}");
}

#[test]
fn a_device_that_never_stops_is_given_up() {
    let mut client = Client::new(ClientRules::default());
    client.step(Event::Connected, 0);
    let mut closed = Vec::new();
    for ms in (0..20_000).step_by(10) {
        let mut actions = client.step(Event::Bytes(b"\0\xFFnoise"), ms * MS);
        actions.extend(client.step(Event::Tick, ms * MS));
        closed.extend(actions.into_iter().filter(|action| matches!(action, Action::Close(_))));
    }
    assert_eq!(closed, [Action::Close(Reason::NeverQuiet { ns: 3000 * MS })]);
}

#[test]
fn a_device_that_resets_for_ever_is_given_up() {
    let mut client = Client::new(ClientRules::default());
    client.step(Event::Connected, 0);
    let reset = text_reply("RESET");
    let mut last = Vec::new();
    for _ in 0..3 {
        last = client.step(Event::Bytes(&reset), MS);
    }
    assert_eq!(last.last(), Some(&Action::Close(Reason::TooManySetups { count: 3 })));
}

#[test]
fn a_late_text_is_not_taken_for_the_version() {
    let plain = DeviceRules {
        bx2: false,
        bx: false,
        ..DeviceRules::default()
    };
    let mut pair = Pair::new(rules(), plain);
    pair.event(Event::Connected);
    pair.show(frame(1, vec![tool(1, 0)]));
    let late = kept_back(&mut pair);
    let mut answer = Vec::new();
    while answer.is_empty() {
        pair.now += 10 * MS;
        let actions = pair.client.step(Event::Tick, pair.now);
        answer = pair.take(actions);
    }
    // A text of TX, where that of VER must come.
    pair.event(Event::Bytes(&late));
    assert!(!pair.client.is_tracking());
    pair.event(Event::Bytes(&answer));
    pair.wait(300);
    assert!(pair.told.contains(&Notice::InStep { tries: 2 }));
}

#[test]
fn after_a_reset_the_device_counts_from_anywhere() {
    let mut pair = tracking();
    pair.show(frame(5000, vec![tool(1, 0)]));
    let reset = pair.device.reset();
    pair.event(Event::Bytes(&reset));
    let told = pair.told.len();
    pair.show(frame(3, vec![tool(1, 0)]));
    assert_eq!(last_number(&pair), Some(3));
    assert!(
        !pair.told[told..]
            .iter()
            .any(|notice| matches!(notice, Notice::Jump { .. }))
    );
}

/// One poll in a second and a half was answered by the reply of two seconds before, whose poses were live.
#[test]
fn a_reply_of_before_is_told_and_not_used_and_a_device_that_counts_anew_is_set_up_again() {
    for (bx2, bx) in [(true, true), (false, true), (false, false)] {
        let device = DeviceRules {
            bx2,
            bx,
            ..DeviceRules::default()
        };
        let mut pair = Pair::new(rules(), device);
        pair.event(Event::Connected);
        pair.show(frame(500, vec![tool(1, 0)]));
        pair.show(frame(380, vec![tool(1, 0)]));
        pair.show(frame(501, vec![tool(1, 0)]));
        let numbers = pair.published.iter().filter_map(|frame| frame.number);
        let numbers: Vec<u32> = numbers.filter(|number| *number >= 300).collect();
        assert_eq!(numbers, [500, 501]);
        assert!(pair.told.contains(&Notice::Back { from: 500, to: 380 }));
        let sent = pair.sent.len();
        for number in 1..60 {
            pair.show(frame(number, vec![tool(1, 0)]));
        }
        assert_eq!(last_number(&pair), Some(501), "59 may be of before");
        pair.show(frame(60, vec![tool(1, 0)]));
        assert!(pair.told.contains(&Notice::CountsAnew { frames: 60 }));
        pair.wait(100);
        assert!(pair.client.is_tracking());
        assert!(pair.sent[sent..].iter().any(|line| line.starts_with("INIT")));
        pair.show(frame(62, vec![tool(1, 0)]));
        assert_eq!(last_number(&pair), Some(62));
    }
}
