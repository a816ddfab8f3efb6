//! The workflow: every pair of state and event, and each rule by its name.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

use std::collections::HashSet;
use std::sync::OnceLock;

use guidance::workflow::{
    Action, Activity, Check, Event, Identity, Mark, May, Rules, RulesError, Stage, State, TABLE, VolumeId, Want, Why,
    in_words, may, step,
};

const A: VolumeId = VolumeId([1; 32]);
const B: VolumeId = VolumeId([2; 32]);
const LIMIT_NS: i64 = 1_000;

fn rules(strict: bool) -> Rules {
    Rules::new(strict, 2.0, LIMIT_NS).unwrap()
}

fn registration(id: u64, volume: VolumeId, is_within_gates: bool) -> Event {
    Event::Registration {
        id,
        volume,
        is_within_gates,
    }
}

fn check(worst_mm: f64, age_ns: i64) -> Event {
    Event::CheckDone { worst_mm, age_ns }
}

fn calibration(id: u64, is_valid: bool) -> Event {
    Event::Calibration { id, is_valid }
}

fn start(check_age_ns: i64) -> Event {
    Event::Start { check_age_ns }
}

/// The way of a strict run, an event a stage.
fn way() -> [Event; 6] {
    [
        Event::VolumeLoaded { volume: A },
        Event::IdentityConfirmed { volume: A },
        calibration(1, true),
        registration(1, A, true),
        check(1.0, 0),
        start(0),
    ]
}

fn after(strict: bool, events: &[Event]) -> State {
    events
        .iter()
        .fold(State::new(rules(strict)), |state, event| step(state, *event).0)
}

/// A strict run at a stage, the tool seen.
fn at(stage: Stage) -> State {
    let events: Vec<Event> = way()[..stage as usize].to_vec();
    let state = after(true, &[events, vec![Event::ToolSeen]].concat());
    assert_eq!(state.stage(), stage);
    state
}

/// What a strict run comes to, an event a row, a column a stage: E L F C R K N for EMPTY, LOADED, CONFIRMED, CALIBRATED, REGISTERED,
/// CHECKED, NAVIGATING. Written by hand from the rules, not from the table.
fn expected() -> Vec<(Event, &'static str)> {
    vec![
        (Event::VolumeLoaded { volume: A }, "LLFCRKN"),
        (Event::VolumeLoaded { volume: B }, "LEEEEEE"),
        (Event::VolumeGone, "EEEEEEE"),
        (Event::IdentityConfirmed { volume: A }, "EFFCRKN"),
        (Event::IdentityConfirmed { volume: B }, "ELLLLLL"),
        (Event::IdentityRejected, "ELLLLLL"),
        (calibration(1, true), "ELCCRKN"),
        (calibration(2, true), "ELCCRRR"),
        (calibration(1, false), "ELFFFFF"),
        (registration(1, A, true), "ELFRRKN"),
        (registration(2, A, true), "ELFRRRR"),
        (registration(1, A, false), "ELFCCCC"),
        (registration(1, B, true), "ELFCCCC"),
        (Event::ReferenceBumped, "ELFCRRR"),
        (check(2.0, LIMIT_NS), "ELFCKKN"),
        (check(2.0001, 0), "ELFCRRR"),
        (check(f64::NAN, 0), "ELFCRRR"),
        (check(-1.0, 0), "ELFCRRR"),
        (check(f64::INFINITY, 0), "ELFCRRR"),
        (check(1.0, LIMIT_NS + 1), "ELFCRRR"),
        (check(1.0, -1), "ELFCRRR"),
        (Event::CheckAge { age_ns: LIMIT_NS }, "ELFCRKN"),
        (Event::CheckAge { age_ns: LIMIT_NS + 1 }, "ELFCRRR"),
        (Event::CheckAge { age_ns: i64::MIN }, "ELFCRRR"),
        (Event::PlanChanged, "ELFCRRN"),
        (start(LIMIT_NS), "ELFCRNN"),
        (start(LIMIT_NS + 1), "ELFCRRN"),
        (start(-1), "ELFCRRN"),
        (Event::Stop, "ELFCRKK"),
        (Event::ToolLost, "ELFCRKN"),
        (Event::ToolSeen, "ELFCRKN"),
        (Event::ImagesOld, "ELFCRKN"),
        (Event::WindowRestarted, "ELFCRKN"),
    ]
}

#[test]
fn every_pair_of_stage_and_event_leads_where_the_rules_say() {
    for (event, stages) in expected() {
        for (stage, letter) in Stage::ALL.into_iter().zip(stages.chars()) {
            let to = Stage::ALL["ELFCRKN".find(letter).unwrap()];
            assert_eq!(step(at(stage), event).0.stage(), to, "{event:?} in {stage:?}");
        }
    }
}

#[test]
fn every_row_of_the_table_is_printed_and_may_be_reached() {
    assert_eq!(in_words().lines().count(), TABLE.len());
    assert!(in_words().contains("CHECKED | Start | check passed, young enough -> NAVIGATING\n"));
    let all = states();
    for row in TABLE {
        let alone = |state: &State| row.from.contains(&state.stage());
        let reached = all.iter().filter(|s| alone(s)).any(|state| {
            let fires = |event: &Event| event.kind() == row.at && row.holds(state, event);
            expected().iter().any(|(event, _)| fires(event))
        });
        assert!(reached, "{row:?}");
    }
}

/// What is true of the world, kept by the test alone, from the events alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Truth {
    volume: Option<VolumeId>,
    confirmed: bool,
    /// The volumes that were rejected and not confirmed since.
    rejected: [bool; 2],
    calibration: Option<u64>,
    registration: Option<u64>,
    /// The registration that was in use last, and whether something speaks against it.
    used: Option<u64>,
    doubted: bool,
    checked: bool,
}

const NOTHING: Truth = Truth {
    volume: None,
    confirmed: false,
    rejected: [false; 2],
    calibration: None,
    registration: None,
    used: None,
    doubted: false,
    checked: false,
};

impl Truth {
    fn empty(&mut self) {
        *self = Self {
            rejected: self.rejected,
            used: self.used,
            doubted: self.doubted,
            ..NOTHING
        };
    }

    fn hear(mut self, event: Event) -> Self {
        match event {
            Event::VolumeLoaded { volume } if self.volume == Some(volume) => {}
            Event::VolumeLoaded { volume } if self.volume.is_none() => self.volume = Some(volume),
            Event::VolumeLoaded { .. } | Event::VolumeGone => self.empty(),
            Event::IdentityConfirmed { volume } => {
                self.confirmed = self.volume == Some(volume);
                if self.confirmed {
                    self.rejected[usize::from(volume == B)] = false;
                }
            }
            Event::IdentityRejected => {
                self.confirmed = false;
                if let Some(volume) = self.volume {
                    self.rejected[usize::from(volume == B)] = true;
                }
            }
            Event::Calibration { id, is_valid } => {
                let id = is_valid.then_some(id);
                self.checked &= self.calibration == id;
                self.calibration = id;
            }
            Event::Registration {
                id,
                volume,
                is_within_gates,
            } => {
                let found = (is_within_gates && self.volume == Some(volume)).then_some(id);
                self.checked &= self.registration == found;
                self.registration = found;
                if found.is_some() && found != self.used {
                    (self.used, self.doubted) = (found, false);
                }
            }
            Event::ReferenceBumped => (self.checked, self.doubted) = (false, true),
            Event::CheckDone { worst_mm, age_ns } => {
                let passes = (0.0..=2.0).contains(&worst_mm);
                self.checked = passes && (0..=LIMIT_NS).contains(&age_ns);
                self.doubted = if self.checked { false } else { self.doubted || !passes };
            }
            _ => {}
        }
        self
    }
}

/// An event of each effect on what is true; the tool is left out, as no stage rests on it.
fn alphabet() -> [Event; 21] {
    let volumes = [A, B].map(|volume| [Event::VolumeLoaded { volume }, Event::IdentityConfirmed { volume }]);
    let [[a, confirm_a], [b, confirm_b]] = volumes;
    [
        a,
        b,
        confirm_a,
        confirm_b,
        Event::VolumeGone,
        Event::IdentityRejected,
        calibration(1, true),
        calibration(2, true),
        calibration(1, false),
        registration(1, A, true),
        registration(2, A, true),
        registration(1, A, false),
        registration(3, B, true),
        Event::ReferenceBumped,
        check(2.0, LIMIT_NS),
        check(2.0001, 0),
        check(1.0, LIMIT_NS + 1),
        Event::CheckAge { age_ns: LIMIT_NS + 1 },
        Event::PlanChanged,
        start(LIMIT_NS),
        Event::Stop,
    ]
}

/// Every state that some sequence of events leads to, with what is then true.
fn walk(strict: bool) -> Vec<(State, Truth)> {
    static WALKS: [OnceLock<Vec<(State, Truth)>>; 2] = [const { OnceLock::new() }; 2];
    let walked = || {
        let mut found = vec![(State::new(rules(strict)), NOTHING)];
        let mut seen = HashSet::new();
        let mut next = 0;
        while let Some(&(state, truth)) = found.get(next) {
            next += 1;
            for event in alphabet() {
                let pair = (step(state, event).0, truth.hear(event));
                if seen.insert((format!("{:?}", pair.0), pair.1)) {
                    found.push(pair);
                }
            }
        }
        found
    };
    WALKS[usize::from(strict)].get_or_init(walked).clone()
}

/// The states alone, each once.
fn states() -> Vec<State> {
    let mut seen = HashSet::new();
    let all = walk(true).into_iter().chain(walk(false));
    let all = all.flat_map(|(state, _)| [state, step(state, Event::ToolSeen).0]);
    all.filter(|state| seen.insert(format!("{state:?}"))).collect()
}

/// By whatever events: who navigates has a volume, its confirmation, a valid calibration, its registration and a fresh check.
#[test]
fn no_way_leads_to_navigating_past_a_gate() {
    for strict in [true, false] {
        let found = walk(strict);
        assert!(found.iter().any(|(state, _)| state.stage() == Stage::Navigating));
        for (state, truth) in found {
            assert_eq!(state.volume(), truth.volume);
            if state.stage() < Stage::Navigating {
                assert!(!state.shows_sight());
                continue;
            }
            assert!(
                truth.volume.is_some() && truth.calibration.is_some() && truth.registration.is_some(),
                "{truth:?}"
            );
            let volume = usize::from(truth.volume == Some(B));
            assert!(!truth.rejected[volume] && !truth.doubted, "{state:?} {truth:?}");
            if strict {
                assert!(truth.confirmed && truth.checked, "{state:?} {truth:?}");
                assert_eq!(state.identity(), Identity::Confirmed);
                assert!(!state.skipped().identity && !state.skipped().check && !state.is_research());
            } else {
                assert!(state.is_research());
                // What is not true is said to be skipped.
                assert!(truth.confirmed || state.skipped().identity, "{state:?} {truth:?}");
                assert!(truth.checked || state.skipped().check, "{state:?} {truth:?}");
            }
        }
    }
}

#[test]
fn navigating_is_entered_by_a_start_alone() {
    for state in states() {
        for (event, _) in expected() {
            let enters = state.stage() < Stage::Navigating && step(state, event).0.stage() == Stage::Navigating;
            assert!(!enters || matches!(event, Event::Start { .. }), "{state:?} {event:?}");
        }
    }
}

#[test]
fn any_change_of_the_volume_leads_to_empty() {
    for state in states() {
        for volume in [A, B] {
            let (next, actions) = step(state, Event::VolumeLoaded { volume });
            match state.volume() {
                Some(held) if held != volume => {
                    assert_eq!((next.stage(), next.volume()), (Stage::Empty, None));
                    assert!(actions.contains(&Action::Forget) && actions.contains(&Action::Ask(Want::Volume)));
                    assert!(actions.contains(&Action::Say(Why::OtherVolume)));
                }
                Some(_) => assert_eq!(next, state),
                None => assert_eq!(next.stage(), Stage::Loaded),
            }
        }
        assert_eq!(step(state, Event::VolumeGone).0.stage(), Stage::Empty);
    }
}

/// The actions tell of every change of what may be shown, and what is refused says why.
#[test]
fn the_sight_is_shown_and_hidden_as_the_state_says() {
    for state in states() {
        for (event, _) in expected() {
            let (next, actions) = step(state, event);
            let [before, now] = [state, next].map(|s| s.shows_sight());
            assert_eq!(actions.contains(&Action::ShowSight), !before && now);
            assert_eq!(actions.contains(&Action::HideSight), before && !now);
            let entered = Action::Entered(next.stage());
            assert_eq!(actions.contains(&entered), next.stage() != state.stage());
            let is_back = next.stage() < state.stage() && event != Event::Stop;
            let says = actions.iter().any(|action| matches!(action, Action::Say(_)));
            assert!(says || !is_back, "{state:?} {event:?}");
            assert_eq!(may(&next, Activity::Sight) != May::No, now);
        }
    }
}

#[test]
fn a_passed_check_stands_in_no_stage_that_does_not_rest_on_it() {
    for state in states() {
        assert!(
            state.check() != Check::Passed || state.stage() >= Stage::Checked,
            "{state:?}"
        );
    }
}

#[test]
fn a_lost_tool_hides_the_sight_and_keeps_the_stage() {
    let (lost, actions) = step(at(Stage::Navigating), Event::ToolLost);
    assert_eq!((lost.stage(), actions), (Stage::Navigating, vec![Action::HideSight]));
    assert_eq!(may(&lost, Activity::Sight), May::No);
    let (seen, actions) = step(lost, Event::ToolSeen);
    assert_eq!((seen, actions), (at(Stage::Navigating), vec![Action::ShowSight]));
}

#[test]
fn old_images_and_a_window_that_ended_change_nothing() {
    for state in states() {
        for event in [Event::ImagesOld, Event::WindowRestarted] {
            assert_eq!(step(state, event), (state, vec![]));
        }
    }
}

#[test]
fn a_bumped_reference_needs_a_check_also_when_its_registration_is_told_again() {
    for strict in [true, false] {
        let bumped = after(strict, &[&way()[..4], &[Event::ReferenceBumped]].concat());
        let (refused, actions) = step(bumped, start(0));
        assert_eq!((refused, actions), (bumped, vec![Action::Say(Why::ReferenceBumped)]));
        let detours: [&[Event]; 4] = [
            &[registration(1, A, true)],
            &[registration(1, A, false), registration(1, A, true)],
            &[calibration(1, false), calibration(1, true), registration(1, A, true)],
            &[Event::VolumeGone, way()[0], way()[1], way()[2], way()[3]],
        ];
        for detour in detours {
            let again = detour.iter().fold(bumped, |state, event| step(state, *event).0);
            assert_eq!(again.stage(), Stage::Registered);
            assert_eq!(step(again, start(0)).0.stage(), Stage::Registered, "{detour:?}");
            let checked = step(again, check(1.0, 0)).0;
            assert_eq!(step(checked, start(0)).0.stage(), Stage::Navigating);
        }
    }
}

#[test]
fn a_rejected_volume_is_not_navigated_in_research_when_it_comes_again() {
    let rejected = [way()[0], Event::IdentityRejected];
    for between in [
        &[][..],
        &[Event::VolumeGone, way()[0]],
        &[Event::IdentityConfirmed { volume: B }],
        &[
            Event::VolumeGone,
            Event::VolumeLoaded { volume: B },
            Event::IdentityRejected,
            Event::VolumeGone,
            way()[0],
        ],
    ] {
        let state = after(false, &[&rejected[..], between, &[calibration(1, true)]].concat());
        assert_eq!(state.stage(), Stage::Loaded, "{between:?}");
    }
}

#[test]
fn research_skips_confirmation_and_check_and_says_so() {
    let short = [way()[0], way()[2], way()[3], way()[5], Event::ToolSeen];
    let state = after(false, &short);
    assert_eq!(state.stage(), Stage::Navigating);
    assert!(state.is_research() && state.skipped().identity && state.skipped().check);
    assert_eq!(may(&state, Activity::Sight), May::Marked(Mark::NotChecked));
    assert_eq!(after(true, &short).stage(), Stage::Loaded);
    // The whole way skips nothing.
    let whole = after(false, &way());
    assert!(!whole.skipped().identity && !whole.skipped().check && whole.is_research());
    // A failed check is not skipped.
    let failed = after(false, &[&short[..3], &[check(9.0, 0), start(0)]].concat());
    assert_eq!((failed.stage(), failed.check()), (Stage::Registered, Check::Failed));
}

#[test]
fn a_check_grows_old_and_a_start_notices_by_itself() {
    let (old, actions) = step(at(Stage::Navigating), Event::CheckAge { age_ns: LIMIT_NS + 1 });
    assert_eq!(old.stage(), Stage::Registered);
    assert_eq!(actions[0], Action::HideSight);
    assert!(actions.contains(&Action::Say(Why::CheckTooOld)) && actions.contains(&Action::Ask(Want::Check)));
    let (old, actions) = step(at(Stage::Checked), start(LIMIT_NS + 1));
    assert_eq!((old.stage(), old.check()), (Stage::Registered, Check::NotMade));
    assert!(actions.contains(&Action::Say(Why::CheckTooOld)));
}

#[test]
fn what_is_refused_says_why() {
    let why = |stage, event| step(at(stage), event);
    for (stage, event, reason) in [
        (Stage::Empty, start(0), Why::NoVolume),
        (Stage::Loaded, calibration(1, true), Why::NotConfirmed),
        (Stage::Loaded, Event::IdentityConfirmed { volume: B }, Why::OtherVolume),
        (Stage::Confirmed, registration(1, A, true), Why::NotCalibrated),
        (Stage::Calibrated, registration(1, B, true), Why::OtherVolume),
        (Stage::Calibrated, registration(1, A, false), Why::NotRegistered),
        (Stage::Calibrated, check(1.0, 0), Why::NotRegistered),
        (Stage::Registered, start(0), Why::NotChecked),
        (Stage::Registered, check(1.0, LIMIT_NS + 1), Why::CheckTooOld),
        (Stage::Registered, Event::Stop, Why::NotNavigating),
        (Stage::Navigating, Event::PlanChanged, Why::Navigating),
    ] {
        let (next, actions) = why(stage, event);
        assert_eq!(next.stage(), stage);
        assert_eq!(actions, [Action::Say(reason)], "{stage:?} {event:?}");
    }
}

/// By hand: a row an activity, a column a stage.
#[test]
fn what_may_be_done_is_what_the_table_of_permissions_says() {
    let letter = |may: May| match may {
        May::No => '-',
        May::Yes => 'y',
        May::Asks => 'a',
        May::AsksAndGoesBack => 'b',
        May::Marked(Mark::NotFollowing) => 'f',
        May::Marked(Mark::NotChecked) => 'c',
        May::Marked(Mark::NotStarted) => 's',
    };
    for (activity, permissions) in [
        (Activity::LookAtSlices, "-yyyyyf"),
        (Activity::TouchPoints, "---yyy-"),
        (Activity::LiveImages, "----cs-"),
        (Activity::Sight, "------y"),
        (Activity::ChangePlan, "-yyyab-"),
    ] {
        let found: String = Stage::ALL
            .map(|stage| letter(may(&at(stage), activity)))
            .iter()
            .collect();
        assert_eq!(found, permissions, "{activity:?}");
    }
}

#[test]
fn rules_that_are_none_are_refused() {
    for gate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Rules::new(true, gate, 1), Err(RulesError::Gate(_))), "{gate}");
    }
    for age in [0, -1, i64::MIN] {
        assert_eq!(Rules::new(true, 1.0, age), Err(RulesError::Age(age)));
    }
}
