//! A queue on the peer's side that grows, with true stamps: it was taken for a clock that was set back, and frames 3 s old for new ones.

use super::super::{Mapped, Mapping, Quality, Settings};
use super::links::{ETHERNET, LINKS, Link, POLLED, Plan, STEPPED, WIFI};
use super::study::ns;

/// What is uncertain of a law on these links, and what it moves by without a step.
const WITHIN_NS: i64 = 6_000_000;

fn mapped(link: &Link) -> Vec<Mapped> {
    let mut mapping = Mapping::new(Settings::default());
    let frames = link.device.iter().zip(&link.arrival);
    frames
        .map(|(&device, &arrival)| mapping.map(ns(device), ns(arrival)))
        .collect()
}

/// A queue from 20 s on, in which the newest frame goes on at a part of the speed of time until it is `most_s` behind, and stays; until the
/// peer drops it at 70 s.
fn queued(plan: &Plan, part: f64, most_s: f64) -> Link {
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
fn nothing_has_waited_where_links_are_busy_and_where_stamps_show_that_a_clock_was_set() {
    for plan in LINKS.iter().chain(&STEPPED) {
        for seed in 0..2 {
            let link = plan.link(seed);
            for (mapped, truth) in mapped(&link).iter().zip(&link.truth) {
                // A frame of a clock that was just set has its arrival, and may have been held up in fact.
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
