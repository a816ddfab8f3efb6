use super::*;
use proptest::prelude::*;

const MS: i64 = 1_000_000;

fn timeline() -> Timeline {
    Timeline::new(Ages {
        stale_ns: 100 * MS,
        lost_ns: 1000 * MS,
    })
}

fn found(states: &States) -> Vec<(String, u64)> {
    let all = State::all().map(|state| (state.words(), states.totals.of(state) / 1_000_000));
    all.filter(|(_, ms)| *ms > 0).collect()
}

fn named(expected: &[(&str, u64)]) -> Vec<(String, u64)> {
    expected.iter().map(|(words, ms)| ((*words).to_owned(), *ms)).collect()
}

#[test]
fn a_gap_is_never_live() {
    let states = |between| {
        let mut timeline = timeline();
        timeline.sample([500 * MS; 2], None, Between::Nothing);
        timeline.sample([520 * MS; 2], None, Between::Nothing);
        timeline.sample([3520 * MS; 2], None, between);
        timeline.finish(0, 3540 * MS, Between::Nothing)
    };
    let silent = states(Between::Nothing);
    let expected = [
        ("no sample yet", 500),
        ("live", 140),
        ("stale", 900),
        ("lost: tracker silent", 2000),
    ];
    assert_eq!(found(&silent), named(&expected));
    assert_eq!((silent.lost_times, silent.longest[0].from_ns), (1, 1520 * MS));
    let missing = states(Between::Missing);
    let expected = [("no sample yet", 500), ("live", 140), ("lost: samples missing", 2900)];
    assert_eq!(found(&missing), named(&expected));
    assert_eq!(
        (missing.longest[0].from_ns, missing.longest[0].why),
        (620 * MS, MISSING)
    );
    let damaged = states(Between::Damage);
    let expected = [("no sample yet", 500), ("live", 140), ("not readable", 2900)];
    assert_eq!(found(&damaged), named(&expected));
    assert_eq!(damaged.lost_times, 0);
}

/// Every image of such a run said OLD, and its report that all of it was live.
#[test]
fn a_pose_that_comes_late_is_not_live_before_it_comes() {
    let states = |late_ms: i64| {
        let mut timeline = timeline();
        for k in 0..100 {
            timeline.sample([10 * MS * k, 10 * MS * k + late_ms * MS], None, Between::Nothing);
        }
        timeline.finish(0, 990 * MS, Between::Nothing)
    };
    assert_eq!(found(&states(30)), named(&[("no sample yet", 30), ("live", 960)]));
    assert_eq!(found(&states(400)), named(&[("no sample yet", 400), ("stale", 590)]));
    // Later than the recording goes on.
    assert_eq!(found(&states(2000)), named(&[("no sample yet", 990)]));
}

#[test]
fn lost_times_go_from_the_first_sample_without_a_pose_to_the_next_with_one() {
    let mut timeline = timeline();
    let reasons = [
        None,
        Some(Lost::TooFew),
        Some(Lost::NotSeen),
        None,
        Some(Lost::Silent),
        None,
    ];
    for (i, lost) in (0..).zip(reasons) {
        timeline.sample([10 * MS * i; 2], lost, Between::Nothing);
    }
    let states = timeline.finish(0, 60 * MS, Between::Nothing);
    let expected = [
        ("live", 30),
        ("lost: marker not seen", 10),
        ("lost: tracker silent", 10),
        ("lost: too few emitters", 10),
    ];
    assert_eq!(found(&states), named(&expected));
    let spans: Vec<_> = states
        .longest
        .iter()
        .map(|s| (s.from_ns / MS, s.to_ns / MS, s.why))
        .collect();
    assert_eq!(spans, [(10, 30, "too few emitters"), (40, 50, "tracker silent")]);
}

#[test]
fn what_follows_on_the_end_of_a_run_is_no_lost_time() {
    let mut timeline = timeline();
    timeline.sample([0; 2], None, Between::Nothing);
    timeline.sample([90 * MS; 2], None, Between::Nothing);
    // The log comes later than samples that were captured behind it.
    timeline.ends(50 * MS);
    timeline.sample([100 * MS; 2], None, Between::Nothing);
    let states = timeline.finish(0, 5000 * MS, Between::Nothing);
    assert_eq!(found(&states), named(&[("live", 50), ("run ending", 4950)]));
    assert_eq!(states.lost_times, 0);
}

#[test]
fn a_recording_without_samples_has_no_live_time() {
    let states = timeline().finish(10 * MS, 510 * MS, Between::Nothing);
    assert_eq!(found(&states), named(&[("no sample yet", 500)]));
}

proptest! {
    /// Whatever comes in whatever order, each ns counts once.
    #[test]
    fn all_states_add_up_to_the_recording(
        samples in prop::collection::vec((0..20_000_i64, 0..12_u32, 0..3_usize, 0..9_000_i64), 0..60),
        ending in prop::option::of(0..20_000_i64),
    ) {
        let mut timeline = timeline();
        if let Some(ms) = ending {
            timeline.ends(ms * MS);
        }
        for &(ms, code, between, late_ms) in &samples {
            let between = [Between::Nothing, Between::Missing, Between::Damage][between];
            timeline.sample([ms * MS, (ms + late_ms) * MS], Lost::from_code(code), between);
        }
        let states = timeline.finish(0, 20_000 * MS, Between::Nothing);
        let all: u64 = State::all().map(|state| states.totals.of(state)).sum();
        prop_assert_eq!(all, 20_000 * MS.unsigned_abs());
        let columns: u64 = states.columns.each().map(|(_, c)| State::all().map(|s| c.of(s)).sum::<u64>()).sum();
        prop_assert_eq!(columns, all);
    }
}
