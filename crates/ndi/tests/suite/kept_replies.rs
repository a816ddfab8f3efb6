//! Replies that somebody between keeps and gives again, and devices that look like that and are not.

use ndi::session::{Action, DeviceRules, Event, Notice};
use ndi::{Bx2Frame, Handle};

use crate::support::{MS, Pair, frame, rules, tool};

/// A device of 100 frames a second, whose clock began an hour before its count.
fn measured(number: u32) -> Bx2Frame {
    Bx2Frame {
        device_ns: 3_600_000 * MS + i64::from(number) * 10 * MS,
        ..frame(number, vec![tool(1, 0), tool(2, 0)])
    }
}

/// Set up, and followed for the first 1000 frames.
fn followed(device: DeviceRules) -> Pair {
    let mut pair = Pair::new(rules(), device);
    pair.event(Event::Connected);
    (1..=1000).for_each(|number| pair.show(measured(number)));
    assert_eq!(last(&pair), 1000);
    pair.published.clear();
    pair
}

/// Connected again after so long.
fn again(pair: &mut Pair, ms: i64) {
    pair.event(Event::Closed);
    pair.now += ms * MS;
    pair.event(Event::Connected);
    pair.wait(50);
    // What a device says that has measured nothing yet has no number, or no tool in it.
    pair.published.clear();
}

fn last(pair: &Pair) -> u32 {
    pair.published.last().and_then(|frame| frame.number).unwrap_or_default()
}

fn devices() -> [DeviceRules; 3] {
    [(true, true), (false, true), (false, false)].map(|(bx2, bx)| DeviceRules {
        bx2,
        bx,
        ..DeviceRules::default()
    })
}

/// Stated: new frames, LIVE at 6 ms. True: the replies of 1.5 s before, over a connection that was made since.
#[test]
fn replies_that_were_kept_are_not_used_over_another_connection_either() {
    for device in devices() {
        let mut pair = followed(device);
        for round in 0..3 {
            again(&mut pair, 100);
            // The same again and again, for 15 s: a device that had begun to count since would be beyond them.
            for number in (0..10).flat_map(|_| 850..=1000) {
                pair.show(measured(number));
            }
            assert!(pair.published.is_empty(), "{round}: {:?}", pair.published.first());
            assert!(pair.client.is_tracking(), "{round}");
        }
        let is_back = |notice: &Notice| matches!(notice, Notice::Back { from: 1000, to: 850 });
        assert!(pair.told.iter().any(is_back));
        pair.show(measured(1001));
        assert_eq!(last(&pair), 1001);
    }
}

/// Stated: the device counts anew, and after a second LIVE. True: somebody between gave more than 60 kept replies, one after the other.
#[test]
fn replies_that_were_kept_are_no_new_count_however_many_come() {
    for device in devices() {
        let mut pair = followed(device);
        (800..=1000).for_each(|number| pair.show(measured(number)));
        assert!(pair.published.is_empty(), "{:?}", pair.published.first());
        assert!(
            !pair
                .told
                .iter()
                .any(|notice| matches!(notice, Notice::CountsAnew { .. }))
        );
        pair.show(measured(1001));
        assert_eq!(last(&pair), 1001);
    }
}

#[test]
fn a_device_that_was_switched_on_anew_is_followed_at_once_and_told() {
    for device in devices() {
        let mut pair = followed(device.clone());
        again(&mut pair, 3000);
        // Its clock begins where it began before.
        pair.show(measured(200));
        pair.show(measured(201));
        assert_eq!(last(&pair), 201);
        let restarted = Notice::Restarted { from: 1000, to: 200 };
        assert_eq!(pair.told.iter().filter(|notice| **notice == restarted).count(), 1);
        // Its replies of before it was switched off have numbers ahead of these.
        (0..10)
            .flat_map(|_| 850..=1000)
            .for_each(|number| pair.show(measured(number)));
        assert_eq!(last(&pair), 201);
        pair.show(measured(1712));
        assert_eq!(last(&pair), 1712, "15 s later");
        // On the next connection it is the new count that goes on.
        again(&mut pair, 100);
        pair.show(measured(1712));
        pair.show(measured(1700));
        assert_eq!(last(&pair), 0);
        pair.show(measured(1720));
        assert_eq!(last(&pair), 1720);
        // In 3 s it takes 300 frames, or some more.
        let mut pair = followed(device);
        again(&mut pair, 3000);
        pair.show(measured(500));
        assert_eq!(last(&pair), 0);
    }
}

/// Its old numbers are ahead of its new ones, over the next connection too.
#[test]
fn replies_of_before_a_device_was_switched_on_anew_are_not_used() {
    for device in devices() {
        let mut pair = followed(device);
        again(&mut pair, 3000);
        (200..400).for_each(|number| pair.show(measured(number)));
        assert_eq!(last(&pair), 399);
        again(&mut pair, 1000);
        (0..10)
            .flat_map(|_| 850..=1000)
            .for_each(|number| pair.show(measured(number)));
        assert_eq!(last(&pair), 0);
    }
}

#[test]
fn a_device_that_counts_on_is_followed_though_its_clock_was_set_back() {
    let mut pair = followed(DeviceRules::default());
    again(&mut pair, 3000);
    let set_back = |number| Bx2Frame {
        device_ns: measured(number).device_ns - 60_000 * MS,
        ..measured(number)
    };
    pair.show(set_back(1300));
    pair.show(set_back(1301));
    assert_eq!(last(&pair), 1301);
}

/// One odd number would have refused the device over all connections to come.
#[test]
fn a_single_number_far_off_is_not_what_the_next_connection_is_held_against() {
    let mut pair = followed(DeviceRules::default());
    pair.show(measured(1_000_000));
    assert_eq!(last(&pair), 1_000_000);
    again(&mut pair, 100);
    pair.show(measured(1030));
    assert_eq!(last(&pair), 1030);
}

/// Stated: nothing comes. True: frames came, whose number stood still while their time went on.
#[test]
fn frames_whose_number_stands_still_while_time_goes_on_say_so_and_have_no_pose() {
    let mut pair = followed(DeviceRules::default());
    let standing = |ms: i64| Bx2Frame {
        device_ns: measured(1000).device_ns + ms * MS,
        ..measured(1000)
    };
    for ms in (10..500).step_by(10) {
        pair.show(standing(ms));
    }
    assert!(pair.published.is_empty(), "a frame may be stamped when it is asked for");
    let told = |pair: &Pair| {
        let stands = |notice: &&Notice| matches!(notice, Notice::Stands { number: 1000 });
        pair.told.iter().filter(stands).count()
    };
    assert_eq!(told(&pair), 0);
    for ms in [500, 510, 510, 505, 520] {
        pair.show(standing(ms));
    }
    assert_eq!((told(&pair), pair.published.len()), (3, 3));
    for frame in pair.published.drain(..) {
        assert!(frame.tools.iter().all(|sight| sight.pose().is_err()), "{frame:?}");
        assert!(
            frame.markers.iter().all(|marker| marker.place_mm().is_err()),
            "{frame:?}"
        );
    }
    pair.show(measured(1060));
    assert!(pair.published[0].tool(Handle(1)).unwrap().pose().is_ok());
}

/// A reply to a poll whose frame stands is not given as [`ndi::FrameStep::Same`].
#[test]
fn what_is_published_names_how_it_follows() {
    let mut pair = followed(DeviceRules::default());
    pair.device.show(Bx2Frame {
        device_ns: measured(1100).device_ns,
        ..measured(1000)
    });
    pair.now += 10 * MS;
    let actions = pair.client.step(Event::Tick, pair.now);
    let replies = pair.take(actions);
    let actions = pair.client.step(Event::Bytes(&replies), pair.now);
    let stands = ndi::FrameStep::Stands { number: 1000 };
    let is_told = |action: &Action| matches!(action, Action::Publish(_, step) if *step == stands);
    assert_eq!(actions.iter().filter(|action| is_told(action)).count(), 1);
}
