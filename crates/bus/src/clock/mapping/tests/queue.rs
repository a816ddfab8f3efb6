//! A queue on the peer's side that grows, with true stamps: it was taken for a clock that was set back, and frames 3 s old for new ones.

use super::super::{Mapped, Mapping, Quality, Settings};
use super::links::{ETHERNET, LINKS, Link, POLLED, Plan, STEPPED, WIFI};
use super::study::ns;

/// What is uncertain of a law on these links, and what it moves by without a step.
pub(super) const WITHIN_NS: i64 = 6_000_000;

fn mapped(link: &Link) -> Vec<Mapped> {
    let mut mapping = Mapping::new(Settings::default());
    let frames = link.device.iter().zip(&link.arrival);
    frames
        .map(|(&device, &arrival)| mapping.map(ns(device), ns(arrival)))
        .collect()
}

/// A queue from 20 s on, in which the newest frame goes on at a part of the speed of time until it is `most_s` behind, and stays; until the
/// peer drops it at 70 s.
pub(super) fn queued(plan: &Plan, part: f64, most_s: f64) -> Link {
    let mut link = plan.link(3);
    for (truth, arrival) in link.truth.iter().zip(&mut link.arrival) {
        let waited = ((truth - 20.0) * (1.0 / part - 1.0)).clamp(0.0, most_s);
        *arrival += if *truth < 70.0 { waited } else { 0.0 };
    }
    // A frame that was dropped never comes: what came after it is in order.
    let last = link.truth.iter().zip(&link.arrival).filter(|(truth, _)| **truth < 70.0);
    let until = last.map(|(_, arrival)| *arrival).fold(0.0, f64::max);
    let kept: Vec<usize> = (0..link.truth.len())
        .filter(|k| link.truth[*k] < 70.0 || link.arrival[*k] > until)
        .collect();
    for column in [&mut link.device, &mut link.arrival, &mut link.truth] {
        *column = kept.iter().map(|k| column[*k]).collect();
    }
    link
}

#[test]
fn frames_of_a_queue_that_grows_are_never_stated_younger_than_they_are() {
    for (plan, rate_hz) in [(ETHERNET, 20.0), (ETHERNET, 60.0), (WIFI, 60.0), (POLLED, 60.0)] {
        let plan = Plan {
            rate_hz,
            length_s: 90.0,
            ..plan
        };
        for (part, most_s) in [(0.5, 3.0), (0.95, 3.0), (0.95, 0.2), (0.3, 8.0), (1.0 / 3.0, 0.04)] {
            let link = queued(&plan, part, most_s);
            let all = mapped(&link);
            for (mapped, truth) in all.iter().zip(&link.truth).filter(|(_, truth)| **truth > 1.0) {
                let stated = mapped.capture_ns.saturating_sub(mapped.waited_ns);
                let younger = stated - ns(*truth);
                assert!(
                    younger < WITHIN_NS,
                    "{} {rate_hz} Hz {part} {most_s}: {truth} by {younger} ns, {mapped:?}",
                    plan.name
                );
            }
            // It has ended: nobody waits any more.
            assert!(
                all[all.len() - 1].waited_ns < 2 * WITHIN_NS,
                "{part} {most_s}: {:?}",
                all.last()
            );
        }
    }
}

#[test]
fn nothing_has_waited_where_links_are_busy() {
    for plan in &LINKS {
        for seed in 0..2 {
            let link = plan.link(seed);
            for (mapped, truth) in mapped(&link).iter().zip(&link.truth) {
                // What was held up and has its arrival counts as held up.
                let older = ns(*truth) - mapped.capture_ns.saturating_sub(mapped.waited_ns);
                assert!(
                    mapped.waited_ns == 0 || (mapped.quality != Quality::Mapped && older < WITHIN_NS),
                    "{}: {truth} by {older} ns, {mapped:?}",
                    plan.name
                );
            }
        }
    }
}

/// A clock that is set back gives the stamps of a queue, or of a peer that hands on once more what it kept: its frames count as that old, and as no
/// older, until it is set forward.
#[test]
fn a_clock_that_is_set_back_counts_as_a_queue_of_that_length() {
    for plan in &STEPPED {
        let link = plan.link(1);
        for (mapped, truth) in mapped(&link).iter().zip(&link.truth).filter(|(_, truth)| **truth > 1.0) {
            let set_s: f64 = plan
                .steps
                .iter()
                .filter(|(at, _)| truth >= at)
                .map(|(_, by)| by.min(0.0).abs())
                .sum();
            if mapped.quality != Quality::Mapped {
                continue;
            }
            let older = ns(*truth) - mapped.capture_ns.saturating_sub(mapped.waited_ns);
            assert!(
                (-WITHIN_NS..ns(set_s) + 2 * WITHIN_NS).contains(&older),
                "{}: {truth} by {older} ns, {mapped:?}",
                plan.name
            );
        }
    }
}

/// A peer that sends nothing for a tool that it does not see may have a queue when it sees it again.
#[test]
fn frames_that_have_waited_behind_a_silence_are_found_late_by_the_law_before_it() {
    for (silent_s, waited_s) in [(10.0, 3.0), (40.0, 3.0), (40.0, 0.0)] {
        let mut link = Plan {
            length_s: 90.0,
            silent: |t| t > 20.0 && t < 60.0,
            ..ETHERNET
        }
        .link(1);
        for column in [&mut link.device, &mut link.arrival, &mut link.truth] {
            let later = column.partition_point(|t| *t % 1000.0 < 40.0);
            column[later..].iter_mut().for_each(|t| *t -= 40.0 - silent_s);
        }
        let late = link.truth.partition_point(|t| *t < 20.5);
        link.arrival[late..].iter_mut().for_each(|t| *t += waited_s);
        let last = mapped(&link).pop().map_or(0, |mapped| mapped.waited_ns);
        assert!((last - ns(waited_s)).abs() < WITHIN_NS, "{silent_s} {waited_s}: {last}");
    }
}

/// A peer that falls back to the beginning of what it keeps, and goes on so, was a clock that had been set: 2 s old, and LIVE.
#[test]
fn frames_that_a_peer_hands_on_once_more_are_as_old_as_they_are() {
    for (back, every) in [(120, 1), (24, 1), (120, 3)] {
        let mut link = Plan {
            length_s: 60.0,
            ..ETHERNET
        }
        .link(5);
        let from = link.truth.partition_point(|t| *t < 30.0);
        for column in [&mut link.device, &mut link.truth] {
            let kept: Vec<f64> = column[from - back..column.len() - back].to_vec();
            // Not each of them: a peer that keeps less.
            let kept = kept.chunks(every).flat_map(|some| vec![some[0]; some.len()]);
            column.truncate(from);
            column.extend(kept);
        }
        for (mapped, truth) in mapped(&link).iter().zip(&link.truth).filter(|(_, truth)| **truth > 1.0) {
            let younger = mapped.capture_ns.saturating_sub(mapped.waited_ns) - ns(*truth);
            assert!(
                younger < WITHIN_NS,
                "{back} {every}: {truth} by {younger} ns, {mapped:?}"
            );
        }
    }
}

/// A queue of 2 s was forgotten as its peer's clock was set back or forward by 3 s, and right again 3 s later.
#[test]
fn a_clock_that_is_set_and_set_right_ends_no_queue() {
    for set_s in [-3.0, 3.0] {
        let plan = Plan {
            length_s: 60.0,
            ..ETHERNET
        };
        let mut link = queued(&plan, 0.5, 2.0);
        for (device, truth) in link.device.iter_mut().zip(&link.truth) {
            *device += if (30.0..33.0).contains(truth) { set_s } else { 0.0 };
        }
        for (mapped, truth) in mapped(&link).iter().zip(&link.truth).filter(|(_, truth)| **truth > 1.0) {
            let younger = mapped.capture_ns.saturating_sub(mapped.waited_ns) - ns(*truth);
            assert!(younger < WITHIN_NS, "{set_s}: {truth} by {younger} ns, {mapped:?}");
        }
    }
}

/// Two frames that change places now and then, or a stamp that is a little back, vouched for a clock that had been set: a queue of the size of all
/// of them together was hidden, and 3 s of it one after the other.
#[test]
fn stamps_that_go_back_and_are_made_up_for_hide_no_queue() {
    for (every, back_s, part) in [
        (120, 0.0, 0.5),
        (120, 0.0, 0.95),
        (10, 0.005, 0.5),
        (10, 0.005, 0.95),
        (30, 0.0001, 0.8),
    ] {
        let plan = Plan {
            length_s: 90.0,
            ..ETHERNET
        };
        let mut link = queued(&plan, part, 3.0);
        for k in (every..link.device.len()).step_by(every) {
            match back_s {
                0.0 => {
                    link.device.swap(k, k - 1);
                    link.truth.swap(k, k - 1);
                }
                back_s => link.device[k] = link.device[k - 1] - back_s,
            }
        }
        for (mapped, truth) in mapped(&link).iter().zip(&link.truth).filter(|(_, truth)| **truth > 6.0) {
            // From where on the law is that of a clock.
            let younger = mapped.capture_ns.saturating_sub(mapped.waited_ns) - ns(*truth);
            assert!(
                younger < WITHIN_NS,
                "{every} {back_s} {part}: {truth} by {younger} ns, {mapped:?}"
            );
        }
    }
}

/// A frame of 3 s ago, or a few, that came once more with their own stamps, had the time of their arrival and vouched for each other.
#[test]
fn frames_that_come_once_more_are_as_old_as_they_say() {
    for (plan, many) in [ETHERNET, WIFI]
        .into_iter()
        .flat_map(|plan| [1, 2, 5, 20].map(|many| (plan, many)))
    {
        let link = Plan { length_s: 60.0, ..plan }.link(1);
        let mut mapping = Mapping::new(Settings::default());
        let frames: Vec<_> = link.device.iter().zip(&link.arrival).zip(&link.truth).collect();
        for (k, ((device, arrival), _)) in frames.iter().enumerate() {
            let _ = mapping.map(ns(**device), ns(**arrival));
            if k % 200 != 199 || k < 600 {
                continue;
            }
            // Each other time over another connection, whose law has not begun.
            if k % 400 == 399 {
                mapping.reconnected();
            }
            for ((device, _), truth) in &frames[k - 180..k - 180 + many] {
                let again = mapping.map(ns(**device), ns(**arrival) + 1000);
                let younger = again.capture_ns.saturating_sub(again.waited_ns) - ns(**truth);
                assert!(
                    younger < WITHIN_NS,
                    "{} {many} at {k}: by {younger} ns, {again:?}",
                    plan.name
                );
            }
        }
    }
}
