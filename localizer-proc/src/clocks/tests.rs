//! Clocks of one connection, and of one after another.

mod repeated;

use super::*;
use crate::driver::Seen;

/// As the scene has it unless it says otherwise.
const LATEST_NS: i64 = 300_000_000;

fn frame(device_ns: i64, first_ns: i64) -> Frame {
    Frame {
        device_ns,
        first_ns,
        arrival_ns: first_ns + 1_000_000,
        asked_ns: first_ns,
        seen: Vec::new(),
    }
}

/// 2026, as a device that states UTC has it.
const EPOCH_NS: i64 = 1_790_000_000_000_000_000;

#[test]
fn stamps_are_mapped_once_there_are_enough_and_never_later_than_the_arrival() {
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, LATEST_NS);
    for i in 0..100 {
        let t_ns = i * 16_666_667;
        // Every fifth frame is 5 ms late.
        let late_ns = if i % 5 == 3 { 5_000_000 } else { 0 };
        let (captured, event) = clock.capture(&frame(EPOCH_NS + t_ns, t_ns + 400_000 + late_ns));
        assert_eq!(event, None);
        let (rests, off_ns) = if i < 8 {
            (CaptureClock::Arrival, late_ns)
        } else {
            (CaptureClock::Mapped, 0)
        };
        assert_eq!((captured.clock, captured.uncertain_ns > 0), (rests, i >= 8), "{i}");
        // The frames themselves are 33 ppm of nothing off: 0.1 ms is what the first law may be wrong by.
        assert!(
            (captured.at_ns - (t_ns + 400_000 + off_ns)).abs() < 100_000,
            "{i}: {captured:?}"
        );
    }
    assert!(clock.words().starts_with("clock mapped to 0."), "{}", clock.words());
}

/// A reply of a device of NDI that the network held up by 0.4 s was stated 0.4 s too young, to 0.02 s.
#[test]
fn a_reply_that_is_late_is_as_old_as_its_question_may_be() {
    for rule in [StampRule::Mapped, StampRule::Arrival] {
        let mut clock = DeviceClock::new(rule, 0, 0).polled();
        for i in 0..60 * 40_i64 {
            let t_ns = i * STEP_NS;
            let late_ns = match i / 60 {
                0..20 => 300_000,
                20..30 => 80_000_000,
                _ => 400_000_000,
            };
            let asked = Frame {
                asked_ns: t_ns,
                ..frame(EPOCH_NS + t_ns, t_ns + late_ns)
            };
            let (captured, _) = clock.capture(&asked);
            assert!(captured.at_ns - t_ns <= 1_000_000, "{i}: {captured:?}");
            // And hardly older: replies are as long apart as questions.
            assert!(t_ns - captured.at_ns <= 2_000_000, "{i}: {captured:?}");
        }
    }
}

/// A queue of 3 s that another connection had found, and a process that was started in the place of one that died, were forgotten, or never.
#[test]
fn a_queue_is_known_to_who_comes_next_and_ends_when_the_clock_steps_forward() {
    let queue_ns = 3_000_000_000;
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, 0);
    let run = |clock: &mut DeviceClock, seconds: std::ops::Range<i64>, late_ns: i64| {
        let mut last = None;
        for i in seconds.start * 60..seconds.end * 60 {
            let t_ns = i * STEP_NS;
            last = Some((t_ns, clock.capture(&frame(EPOCH_NS + t_ns, t_ns + late_ns)).0));
        }
        let (t_ns, captured) = last.unwrap();
        (captured.at_ns - t_ns) / 1_000_000
    };
    run(&mut clock, 0..20, 300_000);
    assert!(run(&mut clock, 20..40, queue_ns) <= 6);
    let mut next = DeviceClock::new(StampRule::Mapped, 0, 0).going_on(clock.hand_over());
    clock.reconnected();
    for clock in [&mut clock, &mut next] {
        assert!(
            (clock.waited_ns() - queue_ns).abs() < 6_000_000,
            "{}",
            clock.waited_ns()
        );
        assert!(run(clock, 40..60, queue_ns) <= 6);
        run(clock, 60..80, 300_000);
        assert_eq!(clock.waited_words(), "");
    }
}

/// Frames that leave the law count as late until it has followed: another connection, whose law begins anew, says no less of them.
#[test]
fn what_was_said_of_the_last_frame_is_carried_to_the_next_connection() {
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, 0);
    let t_ns = 60 * 20 * STEP_NS;
    for i in 0..60 * 20 {
        clock.capture(&frame(EPOCH_NS + i * STEP_NS, i * STEP_NS + 300_000));
    }
    let late_ns = 3_000_000_000;
    clock.capture(&frame(EPOCH_NS + t_ns - late_ns, t_ns + 300_000));
    clock.reconnected();
    // To 6 ms, as the law is known to.
    assert!((clock.waited_ns() - late_ns).abs() < 6_000_000, "{}", clock.waited_ns());
}

/// Two frames in one piece had one time of arrival, and the tracker left the second one out.
#[test]
fn no_two_frames_have_one_time() {
    for rule in [StampRule::Mapped, StampRule::Arrival] {
        let mut clock = DeviceClock::new(rule, 0, LATEST_NS);
        let mut last_ns = i64::MIN;
        for i in 0..2000_i64 {
            // Three by three, with the last of them.
            let arrival_ns = (i / 3 * 3 + 2) * 1_000_000 + 400_000;
            let (captured, _) = clock.capture(&frame(EPOCH_NS + i * 1_000_000, arrival_ns));
            assert!(
                captured.at_ns > last_ns && captured.at_ns <= arrival_ns + MOST_AHEAD_NS,
                "{i}"
            );
            last_ns = captured.at_ns;
        }
    }
}

/// The last message came again, byte for byte, or a tool's TDATA behind its TRANSFORM: each had the time of its arrival, and a link that stood still
/// for 0.6 s made poses 0.6 s too young.
#[test]
fn a_message_that_comes_again_is_no_newer() {
    let seen = |stamp: i64, arrival: i64| Frame {
        seen: vec![Seen {
            marker: 0,
            outcome: Ok((geometry::Rigid::identity(), 0.0)),
        }],
        ..frame(EPOCH_NS + stamp * STEP_NS, arrival * STEP_NS)
    };
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, LATEST_NS);
    let mut last_ns = 0;
    for i in 0..600 {
        last_ns = clock.capture(&seen(i, i)).0.at_ns;
    }
    for k in 1..100 {
        let again = clock.capture(&seen(599, 599 + k)).0;
        assert_eq!((again.at_ns, clock.is_again()), (last_ns, true), "{k}");
    }
    // But of a tool that is not seen, which has the stamp of when it was.
    for k in 700..720 {
        let mut lost = frame(EPOCH_NS + 599 * STEP_NS, k * STEP_NS);
        lost.seen = vec![Seen {
            marker: 0,
            outcome: Err(bus::message::Lost::NotSeen),
        }];
        let captured = clock.capture(&lost).0;
        assert!(
            !clock.is_again() && (k == 700 || captured.at_ns == k * STEP_NS),
            "{k}: {captured:?}"
        );
    }
}

/// A pose of 0.4 s before, behind each new one, was put to a nanosecond behind that.
#[test]
fn a_frame_of_before_keeps_its_place_before() {
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, LATEST_NS);
    for i in 0..1200 {
        let (t_ns, late_ns) = (i * STEP_NS, 24 * STEP_NS);
        clock.capture(&frame(EPOCH_NS + t_ns, t_ns));
        if i > 600 {
            let old = clock.capture(&frame(EPOCH_NS + t_ns - late_ns, t_ns + 1_000_000)).0;
            assert!((old.at_ns - (t_ns - late_ns)).abs() < 1_000_000, "{i}: {old:?}");
        }
    }
}

#[test]
fn a_localizer_without_stamps_has_the_arrival_and_says_so() {
    let mut clock = DeviceClock::new(StampRule::Mapped, 2_000_000, LATEST_NS);
    let (captured, event) = clock.capture(&frame(0, 10_000_000));
    assert_eq!(
        (captured.at_ns, captured.uncertain_ns, captured.clock),
        (8_000_000, 0, CaptureClock::Arrival)
    );
    assert_eq!(
        event.unwrap(),
        "frames have the time of their arrival: the device states no time"
    );
    assert_eq!(clock.words(), "clock: arrival");
    let mut clock = DeviceClock::new(StampRule::Arrival, 2_000_000, LATEST_NS);
    let (captured, event) = clock.capture(&frame(EPOCH_NS, 10_000_000));
    assert_eq!(
        (captured.at_ns, captured.clock, event),
        (8_000_000, CaptureClock::Arrival, None)
    );
}

/// A clock whose frames came at 60 Hz for `seconds`, an image `late_ns` after each second one; and the time of the last.
fn followed(seconds: i64, late_ns: i64) -> (DeviceClock, i64) {
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, LATEST_NS);
    let mut t_ns = 0;
    for i in 0..60 * seconds {
        t_ns = i * STEP_NS;
        clock.capture(&frame(EPOCH_NS + t_ns, t_ns));
        if i % 2 == 0 {
            clock.capture_of_image(EPOCH_NS + t_ns - late_ns, t_ns);
        }
    }
    (clock, t_ns)
}

const STEP_NS: i64 = 16_666_667;

/// A law that no frame follows any more was used for images for ever.
#[test]
fn an_image_is_mapped_only_while_frames_are() {
    let mut none = DeviceClock::new(StampRule::Mapped, 0, LATEST_NS);
    assert_eq!(none.capture_of_image(EPOCH_NS, 0).untimed, Some(Untimed::NoPoses));
    let late_ns = 150_000_000;
    let (mut clock, t_ns) = followed(4, late_ns);
    let seen = clock.capture_of_image(EPOCH_NS + t_ns - late_ns, t_ns);
    assert_eq!((seen.captured.clock, seen.untimed), (CaptureClock::Mapped, None));
    assert!((seen.captured.at_ns - (t_ns - late_ns)).abs() < 100_000, "{seen:?}");
    let alone = clock.capture_of_image(EPOCH_NS + t_ns + 1_000_000_000, t_ns + 1_100_000_000);
    assert_eq!(
        (alone.untimed, alone.captured.uncertain_ns),
        (Some(Untimed::NoPoses), 0)
    );
    // Frames without stamps are timed by their arrival, and so are images.
    clock.capture(&frame(0, t_ns + STEP_NS));
    let unsure = clock.capture_of_image(EPOCH_NS + t_ns, t_ns + STEP_NS);
    assert_eq!(unsure.captured.clock, CaptureClock::Arrival);
}

/// Images by a clock that was up to 2 s off the poses', or was set while they came, had a time by the poses' law.
#[test]
fn images_of_another_clock_or_of_one_that_was_set_are_timed_by_their_arrival() {
    let late_ns = 50_000_000;
    for (off_ns, why) in [
        (400_000_000, Untimed::Late { latest_ns: LATEST_NS }),
        (1_900_000_000, Untimed::Late { latest_ns: LATEST_NS }),
        (-60_000_000, Untimed::OtherClock),
    ] {
        let (mut clock, t_ns) = followed(4, late_ns + off_ns);
        let image = clock.capture_of_image(EPOCH_NS + t_ns - late_ns - off_ns, t_ns);
        assert_eq!((image.untimed, image.captured.at_ns), (Some(why), t_ns));
    }
    let (mut clock, from_ns) = followed(4, late_ns);
    let (mut times, mut set) = (Vec::new(), Vec::new());
    for i in 1..=360 {
        let t_ns = from_ns + i * STEP_NS;
        clock.capture(&frame(EPOCH_NS + t_ns, t_ns));
        let image = clock.capture_of_image(EPOCH_NS + t_ns - late_ns - 100_000_000, t_ns);
        times.push(image.untimed);
        set.extend(image.set_by_ns);
    }
    // A window of two seconds until it is found, another one until it is known.
    assert!(times[..110].iter().all(Option::is_none));
    assert!(
        times[140..235].iter().all(|why| *why == Some(Untimed::Stepped)),
        "{times:?}"
    );
    assert!(times[280..].iter().all(Option::is_none));
    assert!(
        matches!(set[..], [by_ns] if (by_ns + 100_000_000).abs() < 1_000_000),
        "{set:?}"
    );
}

/// A queue of the peer that grew by 3 s was a clock that was set back, and its poses had an age of 0.
#[test]
fn frames_that_may_have_waited_are_that_old_over_another_connection_too_unless_they_were_asked_for() {
    let queued_ns = 3_000_000_000;
    let after_queue = |mut clock: DeviceClock| {
        for i in 0..600 {
            let t_ns = i * STEP_NS;
            let late_ns = if i < 300 { 0 } else { queued_ns };
            let _ = clock.capture(&frame(EPOCH_NS + t_ns, t_ns + late_ns));
        }
        clock
    };
    let new = || DeviceClock::new(StampRule::Mapped, 0, LATEST_NS);
    let mut clock = after_queue(new());
    let within = |ns: i64| (ns - queued_ns).abs() < 1_000_000;
    assert!(within(clock.waited_ns()), "{}", clock.waited_ns());
    let words = clock.waited_words();
    assert!(
        bus::message::may_be_older_ms(&words).is_some_and(|ms| ms.abs_diff(3000) <= 1),
        "{words}"
    );
    // A note holds 96 bytes, and why nothing comes was cut off behind words on the queue.
    let note = format!("{words}; waiting for 127.0.0.1:36605: the peer closed the connection");
    assert!(note.len() <= 96, "{note}");
    let t_ns = 600 * STEP_NS + queued_ns;
    let (captured, _) = clock.capture(&frame(EPOCH_NS + 600 * STEP_NS, t_ns));
    assert!(
        within(t_ns - captured.at_ns) && captured.uncertain_ns >= captured.waited_ns,
        "{captured:?}"
    );
    clock.reconnected();
    let (anew, _) = clock.capture(&frame(EPOCH_NS + 601 * STEP_NS, t_ns + STEP_NS));
    assert!(within(anew.waited_ns) && within(clock.waited_ns()), "{anew:?}");
    assert_eq!(after_queue(new().polled()).waited_ns(), 0);
}
