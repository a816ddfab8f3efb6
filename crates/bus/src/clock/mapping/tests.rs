//! The law on links whose truth is known, and on stamps that no clock gives.

mod connections;
mod found;
pub(crate) mod links;
mod odd;
mod queue;
mod study;

use super::Settings;
use links::{BREAKERS, LINKS, Plan, STEPPED};
use study::Study;

/// Studies of some seeds of a link.
fn studies(plan: &Plan, seeds: u64) -> Vec<Study> {
    (0..seeds)
        .map(|seed| Study::of(&plan.link(seed), Settings::default()))
        .collect()
}

/// The part of mapped frames after 2 s whose error `uncertain_ns` covers.
fn coverage(studies: &[Study]) -> f64 {
    let sum = |count: fn(&Study) -> usize| studies.iter().map(count).sum::<usize>() as f64;
    sum(|s| s.covered) / sum(|s| s.mapped)
}

/// Slower than the 99th of 100 by a third at most: 0.35 ms is the worst of 100 seeds of the worst link.
#[test]
fn on_every_link_99_frames_of_100_are_within_0_6_ms_of_the_truth() {
    for plan in &LINKS {
        for study in studies(plan, 2) {
            let p99 = study.error_quantile(0.99, 30.0);
            assert!(p99 <= 0.6e6, "{}: {p99} ns", plan.name);
            assert_eq!(study.steps, [], "{}", plan.name);
        }
    }
}

#[test]
fn no_stamp_is_later_than_its_arrival_nor_earlier_than_the_one_before() {
    for plan in LINKS.iter().chain(&STEPPED) {
        let study = Study::of(&plan.link(1), Settings::default());
        assert_eq!((study.in_the_future, study.backwards), (0, 0), "{}", plan.name);
    }
}

/// Above 99 %, but for a clock that is slewed faster than the greatest skew: it leaves the law before half a second says so.
fn assert_covered(plan: &Plan, studies: &[Study]) {
    assert!(
        studies.iter().all(|s| (s.in_the_future, s.backwards) == (0, 0)),
        "{}",
        plan.name
    );
    let covered = coverage(studies);
    let least = if plan.name.contains("-500 ppm") { 0.97 } else { 0.99 };
    assert!(covered >= least, "{}: {covered}", plan.name);
}

#[test]
fn what_is_uncertain_covers_the_error_of_99_frames_of_100() {
    for plan in LINKS.iter().chain(&STEPPED) {
        assert_covered(plan, &studies(plan, 1));
    }
}

/// What a new law is wrong by at most: the least delay of the nine frames that it begins with, ns. Of 0.3 ms on the mean that is 0.3 in one case of 8000; a
/// WiFi that is congested and a link that is polled each 20 ms have no short one among nine.
fn least_of_nine_ns(link: &str) -> f64 {
    match link.contains("polled") || link.contains("WiFi") {
        true => 12e6,
        false => 0.3e6,
    }
}

/// From the step to the first frame that is mapped by the new law: nine frames and 120 ms, and what the link holds frames up.
#[test]
fn a_step_is_told_once_with_its_size_and_followed_within_0_3_s() {
    for plan in &STEPPED {
        for study in studies(plan, 2) {
            assert_eq!(study.steps.len(), plan.steps.len(), "{}: {:?}", plan.name, study.steps);
            for (&(told_s, by_ns), &(set_s, by_s)) in study.steps.iter().zip(plan.steps) {
                assert!((0.0..=0.3).contains(&(told_s - set_s)), "{}: {told_s}", plan.name);
                let most_ns = least_of_nine_ns(plan.name);
                assert!((by_ns as f64 - by_s * 1e9).abs() < most_ns, "{}: {by_ns}", plan.name);
                let recovered = study.error_quantile_within(0.99, told_s, told_s + 2.0);
                assert!(recovered <= most_ns, "{}: {recovered}", plan.name);
            }
        }
    }
}

/// What a breaker's error is at most, 99 frames of 100 after 30 s, ns, and how many steps are told.
#[test]
fn what_breaks_the_law_does_so_as_it_is_written_down() {
    let bounds = [
        ("route longer by 5 ms", 5.1e6, 1),
        ("route longer by 5 ms, WiFi", 5.1e6, 1),
        ("route longer by 5 ms, polled", 5.3e6, 1),
        ("route shorter by 5 ms", 0.1e6, 1),
        ("set forward by 2 ms", 0.1e6, 0),
        ("set back by 2 ms", 2.1e6, 1),
        ("set forward by 0.4 ms", 0.1e6, 0),
        ("set back by 0.4 ms", 0.5e6, 0),
        ("skew 100 ppm, +-20 ppm in 600 s", 0.1e6, 0),
        ("10 Hz", 0.1e6, 0),
        ("4 kHz", 0.05e6, 0),
        ("frames in pairs", 0.1e6, 0),
        ("slewed by +500 ppm for 100 s", 0.3e6, 0),
        ("slewed by -500 ppm for 100 s", 10.5e6, 1),
        ("backlog in the first second", 0.1e6, 0),
        ("late burst, then silent for 15 s", 0.1e6, 0),
        ("silent for 60 s", 0.1e6, 0),
        ("all frames late by 30 ms for 10 s", 30.1e6, 2),
        ("queue that grows for 5 s", 0.1e6, 0),
        ("stamps in whole milliseconds", 1.1e6, 0),
    ];
    assert_eq!(bounds.map(|(name, ..)| name), BREAKERS.map(|plan| plan.name));
    for (plan, (_, most, steps)) in BREAKERS.iter().zip(bounds) {
        let study = Study::of(&plan.link(0), Settings::default());
        assert_covered(plan, std::slice::from_ref(&study));
        let p99 = study.error_quantile(0.99, f64::min(30.0, plan.length_s / 2.0));
        assert!(p99 <= most, "{}: {p99} ns", plan.name);
        assert_eq!(study.steps.len(), steps, "{}: {:?}", plan.name, study.steps);
    }
}
