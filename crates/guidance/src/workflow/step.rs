//! One step of the workflow.

use super::event::{Event, Kind};
use super::state::{Check, Identity, Stage, State};
use super::table::{Fact, TABLE};

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// The run has come to another stage: say and record it.
    Entered(Stage),
    /// Forget targets, plan, calibration and registration: they were another volume's.
    Forget,
    /// Sight, digits and verdict may be shown from now on.
    ShowSight,
    /// They may not any more.
    HideSight,
    /// Ask for what leads on from here.
    Ask(Want),
    /// Say that the event was refused or that it took the run back, and why.
    Say(Why),
}

/// What leads on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// A volume.
    Volume,
    /// A person who says whose the volume is; in research the calibration leads on as well.
    Identity,
    /// The tool's calibration.
    Calibration,
    /// The patient's registration.
    Registration,
    /// Known points to be touched; in research a start leads on as well, where nothing speaks against it.
    Check,
    /// A person who starts.
    Start,
}

/// Why an event was refused, or took the run back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// There is no volume.
    NoVolume,
    /// Another volume than the run's.
    OtherVolume,
    /// Nobody has confirmed the identity.
    NotConfirmed,
    /// A person says that the volume is not the patient's.
    IdentityRejected,
    /// There is no valid calibration.
    NotCalibrated,
    /// There is no registration of this volume within its gates.
    NotRegistered,
    /// The reference was bumped: the registration must be checked.
    ReferenceBumped,
    /// The check was not within its gate.
    CheckFailed,
    /// The check is too old.
    CheckTooOld,
    /// There is no check of what holds now.
    NotChecked,
    /// Not while the run navigates.
    Navigating,
    /// The run does not navigate.
    NotNavigating,
}

impl Why {
    /// As a person reads it.
    pub const fn words(self) -> &'static str {
        match self {
            Self::NoVolume => "there is no examination",
            Self::OtherVolume => "another examination than the run's",
            Self::NotConfirmed => "nobody has confirmed whose the examination is",
            Self::IdentityRejected => "a person says that the examination is not the patient's",
            Self::NotCalibrated => "the tool has no valid calibration",
            Self::NotRegistered => "the patient has no registration within its gates",
            Self::ReferenceBumped => "the marker on the patient was pushed: the registration must be checked",
            Self::CheckFailed => "the check of the registration failed",
            Self::CheckTooOld => "the check of the registration is too old",
            Self::NotChecked => "the registration was not checked",
            Self::Navigating => "not while the run navigates",
            Self::NotNavigating => "the run does not navigate",
        }
    }
}

/// The state after an event, and what is to be done. The same state and event always give the same.
///
/// An event without a row of [`TABLE`] leaves the state as it is, and the only action says why.
pub fn step(state: State, event: Event) -> (State, Vec<Action>) {
    let Some(row) = TABLE.iter().find(|row| row.holds(&state, &event)) else {
        let why = refusal(&state, &event);
        return (state, why.map(Action::Say).into_iter().collect());
    };
    let mut next = state;
    next.stage = row.to.unwrap_or(state.stage);
    row.facts.iter().for_each(|fact| apply(&mut next, *fact, &event));
    (next, actions(&state, &next, &event))
}

fn apply(state: &mut State, fact: Fact, event: &Event) {
    match (fact, *event) {
        (Fact::Volume, Event::VolumeLoaded { volume }) => state.volume = Some(volume),
        (Fact::NoVolume, _) => state.volume = None,
        (Fact::Identity(identity), _) => {
            state.identity = identity;
            state.was_rejected |= identity == Identity::Rejected;
        }
        (Fact::Calibration, Event::Calibration { id, .. }) => state.calibration = Some(id),
        (Fact::Registration, Event::Registration { id, .. }) => state.registration = Some(id),
        (Fact::Check(check), _) => state.check = check,
        (Fact::CheckWithdrawn, _) if state.check == Check::Passed => state.check = Check::NotMade,
        (Fact::Tool(is_seen), _) => state.tool_is_seen = is_seen,
        (Fact::Volume | Fact::Calibration | Fact::Registration | Fact::CheckWithdrawn, _) => {}
    }
}

/// What follows from a state and the next. The sight is hidden first.
fn actions(before: &State, after: &State, event: &Event) -> Vec<Action> {
    let mut actions = Vec::new();
    if before.shows_sight() && !after.shows_sight() {
        actions.push(Action::HideSight);
    }
    if before.volume.is_some() && after.volume.is_none() {
        actions.push(Action::Forget);
    }
    actions.extend(taken_back(before, after, event).map(Action::Say));
    if before.stage != after.stage {
        actions.push(Action::Entered(after.stage));
        actions.extend(want(after.stage).map(Action::Ask));
    }
    if !before.shows_sight() && after.shows_sight() {
        actions.push(Action::ShowSight);
    }
    actions
}

const fn want(stage: Stage) -> Option<Want> {
    match stage {
        Stage::Empty => Some(Want::Volume),
        Stage::Loaded => Some(Want::Identity),
        Stage::Confirmed => Some(Want::Calibration),
        Stage::Calibrated => Some(Want::Registration),
        Stage::Registered => Some(Want::Check),
        Stage::Checked => Some(Want::Start),
        Stage::Navigating => None,
    }
}

/// Why a run went back, or does not go on though a row holds.
fn taken_back(before: &State, after: &State, event: &Event) -> Option<Why> {
    let is_back = after.stage < before.stage;
    match event.kind() {
        Kind::VolumeLoaded => is_back.then_some(Why::OtherVolume),
        Kind::IdentityConfirmed => (after.identity != Identity::Confirmed).then_some(Why::OtherVolume),
        Kind::VolumeGone => is_back.then_some(Why::NoVolume),
        Kind::IdentityRejected => Some(Why::IdentityRejected),
        Kind::Calibration if is_back && after.stage < Stage::Calibrated => Some(Why::NotCalibrated),
        Kind::Registration if before.stage < Stage::Calibrated => refusal(before, event),
        // Also where the run stays as it was: the registration was of no use.
        Kind::Registration if after.stage < Stage::Registered => Some(registration(before, event)),
        Kind::ReferenceBumped => Some(Why::ReferenceBumped),
        Kind::CheckDone if after.check == Check::Failed => Some(Why::CheckFailed),
        Kind::CheckDone | Kind::CheckAge | Kind::Start => is_back.then_some(Why::CheckTooOld),
        Kind::Calibration | Kind::Registration | Kind::PlanChanged => is_back.then_some(Why::NotChecked),
        _ => None,
    }
}

fn registration(before: &State, event: &Event) -> Why {
    match *event {
        Event::Registration { volume, .. } if Some(volume) != before.volume => Why::OtherVolume,
        _ => Why::NotRegistered,
    }
}

/// Why an event without a row is refused; `None` where it asks for nothing.
fn refusal(state: &State, event: &Event) -> Option<Why> {
    let missing = match state.stage {
        Stage::Empty => Why::NoVolume,
        Stage::Loaded if state.identity == Identity::Rejected => Why::IdentityRejected,
        Stage::Loaded => Why::NotConfirmed,
        Stage::Confirmed => Why::NotCalibrated,
        Stage::Calibrated => Why::NotRegistered,
        _ => Why::NotChecked,
    };
    match event.kind() {
        Kind::CheckAge => None,
        Kind::Stop => Some(Why::NotNavigating),
        Kind::Start | Kind::PlanChanged if state.stage == Stage::Navigating => Some(Why::Navigating),
        Kind::Start if state.check == Check::Failed => Some(Why::CheckFailed),
        Kind::Start if state.check == Check::Bumped => Some(Why::ReferenceBumped),
        // An invalid calibration in LOADED or CONFIRMED.
        Kind::Calibration
            if matches!(event, Event::Calibration { is_valid: false, .. }) && state.stage > Stage::Empty =>
        {
            Some(Why::NotCalibrated)
        }
        Kind::CheckDone if state.stage == Stage::Registered => Some(Why::CheckTooOld),
        _ => Some(missing),
    }
}
