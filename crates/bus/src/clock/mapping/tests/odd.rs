//! Stamps and arrivals that no clock gives.

use proptest::prelude::*;

use super::super::{Event, Mapped, Mapping, Quality, Reason, Settings};
use super::links::ETHERNET;
use super::study::ns;

const MS: i64 = 1_000_000;
const PERIOD: i64 = 16_666_667;
const HOUR: i64 = 3_600_000 * MS;
/// A device that was switched on an hour ago.
const START: i64 = HOUR;

/// Maps frame `k` of 60 Hz that arrive without jitter: `stamp` of the frame's number gives the device's.
fn run(mapping: &mut Mapping, frames: std::ops::Range<i64>, stamp: impl Fn(i64) -> i64) -> Vec<Mapped> {
    frames.map(|k| mapping.map(stamp(k), k * PERIOD)).collect()
}

fn mapping() -> Mapping {
    Mapping::new(Settings::default())
}

fn reason(mapped: &Mapped) -> Option<Reason> {
    match mapped.quality {
        Quality::Mapped => None,
        Quality::Arrival(reason) => Some(reason),
    }
}

fn events(all: &[Mapped]) -> Vec<Event> {
    all.iter().filter_map(|mapped| mapped.event).collect()
}

#[test]
fn a_clock_that_has_just_begun_is_used_after_nine_frames() {
    let all = run(&mut mapping(), 0..60, |k| START + k * PERIOD);
    let first = all.iter().position(|m| m.quality == Quality::Mapped).unwrap();
    assert!((8..=12).contains(&first), "{first}");
    assert!(
        all[..first]
            .iter()
            .all(|m| reason(m) == Some(Reason::JustBegun) && m.uncertain_ns.is_none())
    );
    assert!(all[first..].iter().all(|m| m.quality == Quality::Mapped));
    assert_eq!(events(&all), []);
}

/// A message that is sent again and again without being packed anew carries its first stamp for ever.
#[test]
fn a_stamp_that_freezes_falls_back_to_the_arrival_and_comes_back_by_itself() {
    let mut mapping = mapping();
    run(&mut mapping, 0..600, |k| START + k * PERIOD);
    let frozen = run(&mut mapping, 600..720, |_| START + 600 * PERIOD);
    assert_eq!(frozen[0].quality, Quality::Mapped);
    for (k, mapped) in frozen.iter().enumerate().skip(1) {
        let wanted = if k as i64 * PERIOD < 500 * MS {
            Reason::Repeated
        } else {
            Reason::Frozen
        };
        assert_eq!(
            (reason(mapped), mapped.capture_ns),
            (Some(wanted), (600 + k as i64) * PERIOD)
        );
    }
    let told = [Reason::Repeated, Reason::Frozen].map(Event::Arrival);
    assert_eq!(events(&frozen), told);
    let after = run(&mut mapping, 720..900, |k| START + k * PERIOD);
    assert!(after.iter().all(|m| m.quality == Quality::Mapped && m.event.is_none()));
}

#[test]
fn a_stamp_that_never_changes_is_never_mapped() {
    let all = run(&mut mapping(), 0..600, |_| START);
    assert!(
        all.iter()
            .all(|m| m.quality != Quality::Mapped && m.uncertain_ns.is_none())
    );
}

#[test]
fn frames_without_a_stamp_are_told_once_and_have_their_arrival() {
    let mut mapping = mapping();
    let all = run(&mut mapping, 0..3600, |_| 0);
    assert!(all.iter().all(|m| reason(m) == Some(Reason::NoStamp)));
    assert_eq!(events(&all), [Event::Arrival(Reason::NoStamp)]);
    assert_eq!(mapping.status().arrivals[Reason::NoStamp as usize], 3600);
}

#[test]
fn milliseconds_for_seconds_and_stamps_of_2106_are_named() {
    // Too large by 1000: the year 57 000 does not fit, and saturates.
    let all = run(&mut mapping(), 0..60, |_| i64::MAX);
    assert_eq!(reason(&all[59]), Some(Reason::OutOfRange));
    let end = u32::MAX.into();
    let all = run(&mut mapping(), 0..60, |k| {
        1_000_000_000_i64.saturating_mul(end) + 999_999_999 + k * PERIOD
    });
    assert_eq!(reason(&all[59]), Some(Reason::OutOfRange));
    // Too slow or too fast by 1000.
    for stamp in [|k| START + k * PERIOD / 1000, |k| START + k * PERIOD * 1000] {
        let all = run(&mut mapping(), 0..1200, stamp);
        assert_eq!(reason(&all[1199]), Some(Reason::Rate));
        let mapped = all[60..].iter().filter(|m| m.quality == Quality::Mapped).count();
        assert!(mapped < 12, "{mapped}");
    }
}

#[test]
fn a_clock_that_jumps_back_by_hours_is_followed_and_told() {
    let mut mapping = mapping();
    run(&mut mapping, 0..600, |k| START + k * PERIOD);
    let after = run(&mut mapping, 600..660, |k| START + k * PERIOD - HOUR / 2);
    assert_eq!(reason(&after[0]), Some(Reason::Backwards));
    let mapped: Vec<_> = after.iter().filter(|m| m.quality == Quality::Mapped).collect();
    assert!(mapped.len() > 45, "{}", mapped.len());
    assert_eq!(events(&after), [Event::Step { by_ns: -HOUR / 2 }]);
    let last = after[59].capture_ns;
    assert!((last - 659 * PERIOD).abs() < MS, "{last}");
}

/// A step of an hour was told with the skew's part of an hour: 3600.072 s at 20 ppm.
#[test]
fn the_size_of_a_step_is_not_that_of_the_skew() {
    for (skew_ppm, by) in [(20, HOUR), (20, -HOUR / 2), (-150, HOUR), (-150, -HOUR / 2)] {
        let mut mapping = mapping();
        // A minute: the skew is known to some ppm.
        let stamp = |k: i64| START + k * PERIOD + k * PERIOD * skew_ppm / 1_000_000;
        run(&mut mapping, 0..3600, stamp);
        let after = run(&mut mapping, 3600..3660, |k| stamp(k) + by);
        let told = events(&after);
        let [Event::Step { by_ns }] = told[..] else {
            panic!("{skew_ppm} {by}: {told:?}")
        };
        // Without jitter the skew is known to 0.1 ppm, and 0.36 ms of an hour are left.
        assert!((by_ns - by).abs() < MS / 2, "{skew_ppm} {by}: off by {} ns", by_ns - by);
    }
}

/// A crystal beyond the greatest skew, from the beginning and for ever: what the law cannot follow looks like a queue that grows.
#[test]
fn a_clock_beyond_the_greatest_skew_is_never_put_late_and_a_slow_one_is_said_to_wait() {
    for skew_ppm in [1000_i64, -300, -1000] {
        let mut mapping = mapping();
        let stamp = |k: i64| START + k * PERIOD + k * PERIOD * skew_ppm / 1_000_000;
        let all = run(&mut mapping, 0..36_000, stamp);
        // The law rests on a frame of the last 20 s.
        let most_early = 20_000 * MS * skew_ppm.min(0).abs() / 1_000_000;
        for (k, mapped) in (0..).zip(&all) {
            let early = k * PERIOD - mapped.capture_ns;
            assert!((0..=most_early).contains(&early), "{skew_ppm}: frame {k} by {early} ns");
        }
        // By what it is slower than 200 ppm for 600 s, to what the law is early by.
        let beyond = (skew_ppm.min(0).abs() - 200).max(0);
        let waited = all.last().map_or(0, |mapped| mapped.waited_ns);
        let expected = beyond * 600 * MS / 1000;
        assert!(
            (waited - expected).abs() <= most_early,
            "{skew_ppm}: {waited} for {expected}"
        );
        assert_eq!(events(&all), []);
    }
}

/// CLOCK_MONOTONIC stands while a machine sleeps: a device's clock is then a minute ahead.
#[test]
fn a_receiver_that_slept_for_a_minute_sees_a_step() {
    let mut mapping = mapping();
    run(&mut mapping, 0..600, |k| START + k * PERIOD);
    let after = run(&mut mapping, 600..660, |k| START + k * PERIOD + 60_000 * MS);
    let wrong = after
        .iter()
        .filter(|m| m.quality == Quality::Mapped && m.uncertain_ns > Some(MS));
    assert_eq!(wrong.count(), 0);
    assert!(after[20..].iter().all(|m| m.quality == Quality::Mapped));
}

#[test]
fn one_stamp_from_the_future_or_the_past_changes_nothing() {
    for wrong in [HOUR / 2, -HOUR / 2, 10 * MS, -10 * MS] {
        let mut mapping = mapping();
        let all = run(&mut mapping, 0..1200, |k| {
            START + k * PERIOD + if k == 600 { wrong } else { 0 }
        });
        let errors = all
            .iter()
            .enumerate()
            .skip(20)
            .map(|(k, m)| (m.capture_ns - k as i64 * PERIOD).abs());
        let far = errors.filter(|error| *error > 11 * MS).count();
        assert_eq!((far, mapping.status().steps), (0, 0), "{wrong}");
    }
}

#[test]
fn arrivals_that_go_back_are_named_and_not_mapped() {
    let mut mapping = mapping();
    run(&mut mapping, 0..600, |k| START + k * PERIOD);
    let mapped = mapping.map(START + 600 * PERIOD, 590 * PERIOD);
    assert_eq!(
        (reason(&mapped), mapped.capture_ns),
        (Some(Reason::ArrivalBackwards), 590 * PERIOD)
    );
}

#[test]
fn a_clock_that_steps_again_and_again_is_called_unsteady_once() {
    let mut mapping = mapping();
    let all = run(&mut mapping, 0..3600, |k| START + k * PERIOD + (k / 60) * 200 * MS);
    let told = events(&all);
    let steps = told.iter().filter(|e| matches!(e, Event::Step { .. })).count();
    assert_eq!((steps, told.len()), (3, 4), "{told:?}");
    assert_eq!(told[3], Event::Arrival(Reason::Unsteady));
    assert_eq!(reason(&all[3599]), Some(Reason::Unsteady));
    let after = run(&mut mapping, 3600..4800, |k| START + k * PERIOD + 60 * 200 * MS);
    assert_eq!(after[1199].quality, Quality::Mapped);
}

#[test]
fn the_least_delay_that_is_stated_is_taken_off() {
    let (link, least_delay_ns) = (ETHERNET.link(1), 5 * MS);
    let mut plain = mapping();
    let mut less = Mapping::new(Settings {
        least_delay_ns,
        ..Settings::default()
    });
    for (&device, &arrival) in link.device.iter().zip(&link.arrival).take(2000) {
        let [a, b] = [&mut plain, &mut less].map(|m| m.map(ns(device), ns(arrival)));
        assert_eq!((a.capture_ns - least_delay_ns, a.quality), (b.capture_ns, b.quality));
    }
}

#[test]
fn the_spread_is_that_of_the_link() {
    let (link, mut mapping) = (ETHERNET.link(1), mapping());
    for (&device, &arrival) in link.device.iter().zip(&link.arrival) {
        let _ = mapping.map(ns(device), ns(arrival));
    }
    let status = mapping.status();
    // Exponential with a mean of 0.3 ms, and spikes of 2 % to 40 ms that hold up those behind them.
    assert!((0.2e6..0.4e6).contains(&(status.spread.p50_ns as f64)), "{status:?}");
    assert!((10e6..40e6).contains(&(status.spread.p99_ns as f64)), "{status:?}");
    assert!((status.skew_ppm + 50.0).abs() < 1.0, "{status:?}");
}

#[test]
fn what_is_told_is_said_in_words() {
    assert_eq!(
        Event::Step { by_ns: -80 * MS }.to_string(),
        "the device's clock was set by -80.000 ms"
    );
    let mut words: Vec<_> = Reason::ALL.iter().map(|r| Event::Arrival(*r).to_string()).collect();
    words.sort();
    words.dedup();
    assert_eq!(words.len(), Reason::ALL.len());
    assert!(Reason::ALL.iter().enumerate().all(|(k, r)| r.index() == k));
}

/// Stamps near one another, near a clock's, and anything.
fn any_stamp() -> impl Strategy<Value = i64> {
    prop_oneof![
        any::<i64>(),
        0..1000_i64,
        START..START + 1000 * PERIOD,
        Just(i64::MIN),
        Just(i64::MAX),
        Just(0),
    ]
}

proptest! {
    #[test]
    fn no_numbers_bring_it_down_or_into_the_future(frames in prop::collection::vec((any_stamp(), any_stamp()), 1..300),
                                                   least_delay_ns in any::<i64>(), window_ns in any::<i64>(),
                                                   skew_ppm in prop::num::f64::ANY) {
        let mut mapping = Mapping::new(Settings { window_ns, skew_ppm, least_delay_ns });
        for (device, arrival) in frames {
            prop_assert!(mapping.map(device, arrival).capture_ns <= arrival);
        }
        prop_assert!(mapping.status().spread.p99_ns >= 0);
    }

    #[test]
    fn nothing_goes_backwards_while_arrivals_do_not(devices in prop::collection::vec(any_stamp(), 1..300), gap in 0..100 * MS) {
        let mut mapping = mapping();
        let mut last = i64::MIN;
        for (k, device) in (0..).zip(devices) {
            let mapped = mapping.map(device, k * gap);
            prop_assert!(mapped.capture_ns >= last && mapped.capture_ns <= k * gap);
            last = mapped.capture_ns;
        }
    }

    /// A clock of any step, skew and jitter, with damaged frames among its own.
    #[test]
    fn a_damaged_clock_never_goes_backwards(by in -HOUR..HOUR, at in 0..600_i64, skew in -300..300_i64,
                                            late in prop::collection::vec(0..30 * MS, 600), odd in any_stamp()) {
        let mut mapping = mapping();
        let (mut last, mut arrival) = (i64::MIN, 0);
        for (k, late) in (0..).zip(late) {
            let set = if k >= at { by } else { 0 };
            let device = if k % 50 == 49 { odd } else { 2 * HOUR + k * (PERIOD + skew * PERIOD / 1_000_000) + set };
            arrival = arrival.max(k * PERIOD + late);
            let mapped = mapping.map(device, arrival);
            prop_assert!(mapped.capture_ns >= last && mapped.capture_ns <= arrival);
            last = mapped.capture_ns;
        }
    }
}

/// What bears a stamp of the same clock and comes later is placed by the law, and the law learns nothing of it: an image's stamp is that
/// of a frame that is long past, and must not look like a clock that was set back.
#[test]
fn an_image_is_placed_by_the_law_of_the_frames_and_leaves_it_alone() {
    let most_late = 2_000 * MS;
    let mut mapping = mapping();
    assert_eq!(mapping.capture_of(START, 0, most_late), None, "nothing is known");
    let all = run(&mut mapping, 0..300, |k| START + k * PERIOD);
    for behind in [0, 3, 60, 119] {
        let k = 299 - behind;
        let (at, uncertain) = mapping.capture_of(START + k * PERIOD, 299 * PERIOD, most_late).unwrap();
        let own = all[k as usize];
        assert!(
            (at - own.capture_ns).abs() <= 20_000,
            "{behind}: {} ns",
            at - own.capture_ns
        );
        assert!((1..MS).contains(&uncertain), "{uncertain}");
    }
    // Of another clock: too late by the law, ahead of it, and none.
    for stamp in [
        START + 299 * PERIOD - 2_001 * MS,
        START + 299 * PERIOD + 4 * MS,
        0,
        -1,
        i64::MAX,
        i64::MIN,
    ] {
        assert_eq!(mapping.capture_of(stamp, 299 * PERIOD, most_late), None, "{stamp}");
    }
    let mut alone = self::mapping();
    run(&mut alone, 0..300, |k| START + k * PERIOD);
    let next = (START + 300 * PERIOD, 300 * PERIOD);
    assert_eq!(mapping.map(next.0, next.1), alone.map(next.0, next.1));
}
