//! Stamps that come again: of a peer that hangs, and of a marker that is not seen, which bears that of when it was.

use bus::message::{Lost, MarkerFrame};
use geometry::rotation::Rotation;
use geometry::{Rigid, Vector};

use super::{EPOCH_NS, STEP_NS};
use crate::clocks::{Captured, DeviceClock};
use crate::driver::{Frame, Seen};
use scene::localizer::StampRule;

const MS: i64 = 1_000_000;
/// What a law is uncertain by.
const WITHIN_NS: i64 = 6 * MS;

fn seen(marker: u32, x: f64) -> Seen {
    let pose = Rigid::from_parts(Rotation::IDENTITY, Vector::new(x, 0.0, 0.0));
    Seen {
        marker,
        outcome: Ok((pose, 0.0)),
    }
}

fn lost() -> Seen {
    Seen {
        marker: MarkerFrame::TOOL,
        outcome: Err(Lost::NotSeen),
    }
}

/// What is made of a frame that was captured at `t_ns` of the device and came at `arrival_ns`.
fn come(clock: &mut DeviceClock, t_ns: i64, arrival_ns: i64, seen: Vec<Seen>) -> Captured {
    let frame = Frame {
        device_ns: EPOCH_NS + t_ns,
        first_ns: arrival_ns,
        arrival_ns,
        asked_ns: arrival_ns,
        seen,
    };
    clock.capture(&frame).0
}

/// Poses of the tool over these seconds, `late_ns` after their capture; the last one.
fn poses(clock: &mut DeviceClock, seconds: std::ops::Range<i64>, late_ns: i64) -> Captured {
    let steps = seconds.start * 60..seconds.end * 60;
    let last = steps.map(|i| come(clock, i * STEP_NS, i * STEP_NS + late_ns, vec![seen(0, i as f64)]));
    last.last().unwrap()
}

fn new() -> DeviceClock {
    DeviceClock::new(StampRule::Mapped, 0, 0)
}

/// A tool that was lost behind a queue of 0.6 s ended it: the status said that poses wait no longer, and to a process that followed on one that
/// died then, poses of 0.6 s before were of the present.
#[test]
fn a_tool_that_is_lost_ends_no_queue() {
    let queue_ns = 600 * MS;
    let mut clock = new();
    poses(&mut clock, 0..20, 300_000);
    poses(&mut clock, 20..40, queue_ns);
    let last_ns = (40 * 60 - 1) * STEP_NS;
    for i in 40 * 60..45 * 60 {
        let arrival_ns = i * STEP_NS + queue_ns;
        let captured = come(&mut clock, last_ns, arrival_ns, vec![lost()]);
        assert!((captured.waited_ns - queue_ns).abs() < WITHIN_NS, "{captured:?}");
        assert!(
            (arrival_ns - captured.at_ns - queue_ns).abs() < WITHIN_NS,
            "{captured:?}"
        );
        assert!(!clock.waited_words().is_empty());
    }
    let mut next = new().going_on(clock.hand_over());
    next.reconnected();
    for clock in [&mut clock, &mut next] {
        for i in 45 * 60..50 * 60 {
            let captured = come(clock, i * STEP_NS, i * STEP_NS + queue_ns, vec![seen(0, i as f64)]);
            assert!(captured.at_ns - i * STEP_NS < WITHIN_NS, "{i}: {captured:?}");
        }
    }
}

/// A lost tool keeps its stamp while the patient's marker goes on: what that stamp was late by, 9 s and more, was told as a queue, and a process that
/// followed on one that died then refused a healthy peer until the run ended.
#[test]
fn the_old_stamp_of_a_lost_tool_is_no_queue() {
    let mut clock = new();
    poses(&mut clock, 0..20, 300_000);
    for i in 20 * 60..30 * 60 {
        let t_ns = i * STEP_NS;
        let patient = seen(MarkerFrame::REFERENCE, i as f64);
        come(&mut clock, t_ns, t_ns + 300_000, vec![lost(), patient]);
        assert_eq!(clock.waited_words(), "", "{i}");
        come(&mut clock, 20 * 60 * STEP_NS - STEP_NS, t_ns + 8 * MS, vec![lost()]);
        assert_eq!(
            (clock.waited_words(), clock.hand_over().waited_ns),
            (String::new(), 0),
            "{i}"
        );
    }
    // Nor to a process that begins with it.
    let mut next = new().going_on(clock.hand_over());
    next.reconnected();
    come(&mut next, 20 * 60 * STEP_NS - STEP_NS, 30 * 60 * STEP_NS, vec![lost()]);
    for clock in [&mut clock, &mut next] {
        let captured = poses(clock, 30..31, 300_000);
        assert!(captured.waited_ns == 0 && captured.uncertain_ns > 0, "{captured:?}");
        assert!(clock.words().contains("p99 0."), "{}", clock.words());
    }
}

/// A peer that hung and sent its last pose as a matrix and as a quaternion in turns, whose numbers are rounded otherwise, was of the present.
#[test]
fn a_peer_that_hangs_is_no_news_in_whatever_kinds_of_message() {
    let mut clock = new();
    let last = poses(&mut clock, 0..20, 300_000);
    let last_ns = (20 * 60 - 1) * STEP_NS;
    for i in 20 * 60..30 * 60 {
        let x = (20 * 60 - 1) as f64 + [0.0, 1e-7][i as usize % 2];
        let captured = come(&mut clock, last_ns, i * STEP_NS, vec![seen(0, x)]);
        // The second kind comes for the first time, and is what it says.
        let is_first = i == 20 * 60 + 1;
        assert_eq!(clock.is_again(), !is_first, "{i}");
        assert!(captured.at_ns - last.at_ns < WITHIN_NS, "{i}: {captured:?}");
    }
}

/// Behind another connection a peer that sent one message of 5.5 s before, again and again, was of the present from when its stamp was called frozen.
#[test]
fn one_old_message_again_and_again_is_no_news_over_another_connection() {
    let mut clock = new();
    poses(&mut clock, 0..20, 300_000);
    clock.reconnected();
    let old_ns = 20 * 60 * STEP_NS - 5_500 * MS;
    for i in 20 * 60..25 * 60 {
        let captured = come(&mut clock, old_ns, i * STEP_NS, vec![seen(0, 7.0)]);
        assert!(
            clock.is_again() || captured.at_ns - old_ns < WITHIN_NS,
            "{i}: {captured:?}"
        );
    }
}
