//! The supervisor, driven by hand.

use super::*;
use scene::Scene;
use std::path::Path;

const MS: i64 = 1_000_000;

/// Loader 0, renderer 1, tracker 2 after both, recorder 3 stopping after them, loader last.
fn supervisor() -> Supervisor {
    let role = |after: &[usize], stop_rank| Role {
        after: after.to_vec(),
        stop_rank,
    };
    let limits = Scene::parse("[limits]\nrestarts = 3", Path::new("")).unwrap().limits;
    Supervisor::new(
        vec![role(&[], 2), role(&[], 0), role(&[0, 1, 3], 0), role(&[], 1)],
        limits,
    )
}

fn all_ready(s: &mut Supervisor, now: i64) {
    s.step(Event::Tick, now);
    for i in [0, 1, 3, 2] {
        s.step(Event::Beat(i, ProcessState::Ready), now);
    }
}

/// Ticks from `from` to `to`, as often as a pilot that is not held up; returns what was decided.
fn watch(s: &mut Supervisor, from: i64, to: i64) -> Vec<Action> {
    let mut times: Vec<i64> = (from..to).step_by((100 * MS) as usize).collect();
    times.push(to);
    times.into_iter().flat_map(|now| s.step(Event::Tick, now)).collect()
}

#[test]
fn the_tracker_starts_when_everybody_else_is_ready() {
    let mut s = supervisor();
    assert_eq!(
        s.step(Event::Tick, 0),
        [Action::Start(0), Action::Start(1), Action::Start(3)]
    );
    assert_eq!(s.step(Event::Beat(1, ProcessState::Ready), 1), []);
    assert_eq!(s.step(Event::Beat(3, ProcessState::Ready), 1), []);
    assert_eq!(s.step(Event::Beat(0, ProcessState::Starting), 2), []);
    assert_eq!(s.step(Event::Beat(0, ProcessState::Ready), 3), [Action::Start(2)]);
    assert_eq!(s.step(Event::Beat(2, ProcessState::Ready), 4), [Action::AllReady]);
    assert_eq!(s.step(Event::Tick, 5), []);
}

#[test]
fn a_killed_process_is_started_again_at_once_and_then_more_slowly() {
    let mut s = supervisor();
    all_ready(&mut s, 0);
    assert_eq!(s.step(Event::Ended(1, Ending::Signal(9)), 10), [Action::Start(1)]);
    assert_eq!(s.step(Event::Ended(1, Ending::Signal(9)), 20), []);
    assert_eq!(s.step(Event::Tick, 20 + 99 * MS), []);
    assert_eq!(s.step(Event::Tick, 20 + 100 * MS), [Action::Start(1)]);
    let t = 20 + 100 * MS;
    assert_eq!(s.step(Event::Ended(1, Ending::Code(1)), t), []);
    assert_eq!(s.step(Event::Tick, t + 200 * MS), [Action::Start(1)]);
}

#[test]
fn a_crash_loop_is_held_and_the_others_go_on() {
    let mut s = supervisor();
    all_ready(&mut s, 0);
    let mut now = 0;
    for _ in 0..3 {
        s.step(Event::Ended(1, Ending::Signal(11)), now);
        now += 3000 * MS;
        for i in [0, 2, 3] {
            s.step(Event::Beat(i, ProcessState::Ready), now);
        }
        assert!(s.step(Event::Tick, now).contains(&Action::Start(1)) || s.stage_word(1) == "starting");
    }
    assert_eq!(s.step(Event::Ended(1, Ending::Signal(11)), now), [Action::GaveUp(1)]);
    assert_eq!(s.step(Event::Tick, now + 1000 * MS), []);
    assert_eq!(s.stage_word(1), "held");
    assert!(s.is_ready(0));
}

#[test]
fn restarts_are_forgiven_after_the_window() {
    let mut s = supervisor();
    all_ready(&mut s, 0);
    for round in 0..20 {
        let now = round * 31_000 * MS;
        for i in 0..4 {
            s.step(Event::Beat(i, ProcessState::Ready), now);
        }
        assert_eq!(
            s.step(Event::Ended(1, Ending::Signal(9)), now),
            [Action::Start(1)],
            "{round}"
        );
        s.step(Event::Beat(1, ProcessState::Ready), now);
    }
}

#[test]
fn a_refusal_before_the_first_readiness_fails_the_run() {
    let mut s = supervisor();
    s.step(Event::Tick, 0);
    let actions = s.step(Event::Ended(0, Ending::Code(1)), 5);
    assert_eq!(actions, [Action::Terminate(1)]);
    assert_eq!(s.step(Event::Ended(1, Ending::Code(0)), 6), [Action::Terminate(3)]);
    let end = s.step(Event::Ended(3, Ending::Code(0)), 7);
    assert_eq!(end, [Action::Finished(Outcome::Refused(0))]);
    assert_eq!(s.step(Event::Tick, 8), []);
}

#[test]
fn a_crash_before_the_first_readiness_is_tried_again() {
    let mut s = supervisor();
    s.step(Event::Tick, 0);
    assert_eq!(s.step(Event::Ended(0, Ending::Signal(9)), 5), [Action::Start(0)]);
}

#[test]
fn a_crash_loop_before_the_first_readiness_fails_the_run() {
    let mut s = supervisor();
    s.step(Event::Tick, 0);
    let mut now = 0;
    for _ in 0..3 {
        assert!(
            !s.step(Event::Ended(0, Ending::Signal(9)), now)
                .contains(&Action::GaveUp(0))
        );
        now += 1500 * MS;
        for i in [1, 3] {
            s.step(Event::Beat(i, ProcessState::Ready), now);
        }
        s.step(Event::Tick, now);
    }
    let actions = s.step(Event::Ended(0, Ending::Signal(9)), now);
    assert_eq!(actions, [Action::GaveUp(0), Action::Terminate(1)]);
    s.step(Event::Ended(1, Ending::Code(0)), now);
    let end = s.step(Event::Ended(3, Ending::Code(0)), now);
    assert_eq!(end, [Action::Finished(Outcome::Refused(0))]);
}

#[test]
fn silence_is_killed_once_and_restarted() {
    let mut s = supervisor();
    all_ready(&mut s, 0);
    let now = 2001 * MS;
    assert_eq!(watch(&mut s, 0, 1500 * MS), []);
    for i in [0, 2, 3] {
        s.step(Event::Beat(i, ProcessState::Ready), 1500 * MS);
    }
    assert_eq!(watch(&mut s, 1500 * MS, now), [Action::Kill(1, KillReason::Silent)]);
    assert_eq!(s.step(Event::Tick, now + 1), []);
    assert_eq!(s.step(Event::Ended(1, Ending::Signal(9)), now + 2), [Action::Start(1)]);
}

/// A machine that was slow to load programs once had all six shot before they had begun, and shot again.
#[test]
fn silence_counts_from_the_first_sign_of_life() {
    let mut s = supervisor();
    s.step(Event::Tick, 0);
    let slow = 100_000 * MS;
    assert_eq!(watch(&mut s, 0, slow), [], "not loaded yet");
    s.step(Event::Beat(0, ProcessState::Starting), slow);
    assert_eq!(watch(&mut s, slow, slow + 2000 * MS), []);
    assert_eq!(
        s.step(Event::Tick, slow + 2001 * MS),
        [Action::Kill(0, KillReason::Silent)]
    );
    // The next one is as slow to load as this one was.
    assert_eq!(
        s.step(Event::Ended(0, Ending::Signal(9)), slow + 2002 * MS),
        [Action::Start(0)]
    );
    assert!(!watch(&mut s, slow + 2002 * MS, slow + 9000 * MS).contains(&Action::Kill(0, KillReason::Silent)));
}

#[test]
fn a_held_process_is_brought_back_and_no_other() {
    let mut s = supervisor();
    s.step(Event::Tick, 0);
    assert_eq!(s.step(Event::Restart(1), 0), [], "it is starting");
    all_ready(&mut s, 0);
    for n in 0..4 {
        s.step(Event::Ended(1, Ending::Signal(9)), n);
        s.step(Event::Tick, n);
    }
    assert_eq!(s.stage_word(1), "held");
    assert_eq!(s.step(Event::Restart(1), 10), [Action::Start(1)]);
    // With as many restarts as at first.
    assert_eq!(s.step(Event::Ended(1, Ending::Signal(9)), 11), [Action::Start(1)]);
    s.step(Event::Stop, 12);
    assert_eq!(s.step(Event::Restart(1), 13), [], "the run is ending");
}

/// One that waits for a person to say so is not held: it was refused.
#[test]
fn one_that_is_ready_makes_room_for_the_next_where_a_person_wants_it() {
    let mut s = supervisor();
    all_ready(&mut s, 0);
    assert_eq!(s.step(Event::Restart(1), 10), [Action::Kill(1, KillReason::Asked)]);
    assert_eq!(s.step(Event::Ended(1, Ending::Signal(9)), 11), [Action::Start(1)]);
}

#[test]
fn an_absence_of_the_supervisor_counts_against_nobody() {
    let mut s = supervisor();
    all_ready(&mut s, 0);
    let back = 60_000 * MS;
    assert_eq!(s.step(Event::Tick, back), []);
    // From then on silence counts again.
    let kills = watch(&mut s, back, back + 2001 * MS);
    assert_eq!(kills, [0, 1, 2, 3].map(|i| Action::Kill(i, KillReason::Silent)));
}

#[test]
fn a_slow_start_is_killed_though_it_beats() {
    let mut s = supervisor();
    s.step(Event::Tick, 0);
    let mut actions = Vec::new();
    for tenth in 1..1300 {
        let now = tenth * 100 * MS;
        for i in [1, 3] {
            actions.extend(s.step(Event::Beat(i, ProcessState::Ready), now));
        }
        actions.extend(s.step(Event::Beat(0, ProcessState::Starting), now));
    }
    assert_eq!(actions, [Action::Kill(0, KillReason::SlowStart)]);
}

#[test]
fn stopping_goes_by_rank_and_kills_the_slow() {
    let mut s = supervisor();
    all_ready(&mut s, 0);
    assert_eq!(s.step(Event::Stop, 1), [Action::Terminate(1), Action::Terminate(2)]);
    assert_eq!(s.step(Event::Stop, 2), []);
    assert_eq!(s.step(Event::Ended(1, Ending::Code(0)), 3), []);
    let late = 3002 * MS;
    assert_eq!(watch(&mut s, 4, late), [Action::Kill(2, KillReason::SlowStop)]);
    assert_eq!(
        s.step(Event::Ended(2, Ending::Signal(9)), late + 1),
        [Action::Terminate(3)]
    );
    assert_eq!(
        s.step(Event::Ended(3, Ending::Code(0)), late + 2),
        [Action::Terminate(0)]
    );
    let end = s.step(Event::Ended(0, Ending::Code(0)), late + 3);
    assert_eq!(end, [Action::Finished(Outcome::Stopped)]);
}
