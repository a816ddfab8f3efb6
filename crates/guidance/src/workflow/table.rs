//! The workflow's rows.

use std::fmt::Write as _;

use super::event::{Event, Kind};
use super::state::{Check, Identity, Stage, State};
use super::when::When;

use Stage::{Calibrated, Checked, Confirmed, Empty, Loaded, Navigating, Registered};

/// What a row changes beside the stage. Not to be named from outside: a fact follows from an event alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fact {
    /// The event's volume is the run's from now on.
    Volume,
    NoVolume,
    Identity(Identity),
    /// The event's calibration is accepted.
    Calibration,
    /// The event's registration is the one that is spoken of from now on.
    Registration,
    Check(Check),
    /// A check that was passed counts as not made; what speaks against the registration stays.
    CheckWithdrawn,
    Tool(bool),
}

/// A row: in one of these stages, at this event, where `when` holds, the run goes to `to`. The first that holds counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// The stages.
    pub from: &'static [Stage],
    /// The event.
    pub at: Kind,
    /// The condition.
    pub when: When,
    /// The stage after; `None`: as before.
    pub to: Option<Stage>,
    pub(super) facts: &'static [Fact],
}

impl Row {
    /// Whether the row's stage, event and condition hold. That a row before it holds as well is not looked at.
    pub fn holds(&self, state: &State, event: &Event) -> bool {
        self.at == event.kind() && self.from.contains(&state.stage()) && self.when.holds(state, event)
    }
}

const fn row(from: &'static [Stage], at: Kind, when: When, to: Option<Stage>, facts: &'static [Fact]) -> Row {
    Row {
        from,
        at,
        when,
        to,
        facts,
    }
}

const ALL: &[Stage] = &Stage::ALL;
const WITH_VOLUME: &[Stage] = &[Loaded, Confirmed, Calibrated, Registered, Checked, Navigating];
const AFTER_CONFIRMED: &[Stage] = &[Calibrated, Registered, Checked, Navigating];
const AFTER_CALIBRATED: &[Stage] = &[Registered, Checked, Navigating];
const AFTER_REGISTERED: &[Stage] = &[Checked, Navigating];
const WITHDRAWN: &[Fact] = &[Fact::CheckWithdrawn];
const CALIBRATION: &[Fact] = &[Fact::Calibration];
const REGISTRATION: &[Fact] = &[Fact::Registration, Fact::Check(Check::NotMade)];
const GONE: &[Fact] = &[Fact::NoVolume, Fact::Identity(Identity::NotAsked), Fact::CheckWithdrawn];
const CONFIRMED: &[Fact] = &[Fact::Identity(Identity::Confirmed)];
const FAILED: &[Fact] = &[Fact::Check(Check::Failed)];
const PASSED: &[Fact] = &[Fact::Check(Check::Passed)];

/// Every row. What has none changes nothing and is refused.
pub const TABLE: &[Row] = &[
    row(
        &[Empty],
        Kind::VolumeLoaded,
        When::Always,
        Some(Loaded),
        &[Fact::Volume],
    ),
    row(WITH_VOLUME, Kind::VolumeLoaded, When::SameVolume, None, &[]),
    // Not to LOADED at once: what was shown and planned is of another patient, and must be seen to go.
    row(WITH_VOLUME, Kind::VolumeLoaded, When::OtherVolume, Some(Empty), GONE),
    row(ALL, Kind::VolumeGone, When::Always, Some(Empty), GONE),
    row(
        &[Loaded],
        Kind::IdentityConfirmed,
        When::SameVolume,
        Some(Confirmed),
        CONFIRMED,
    ),
    row(WITH_VOLUME, Kind::IdentityConfirmed, When::SameVolume, None, CONFIRMED),
    // Somebody was shown another volume than the run's: whose this one is, nobody has said.
    row(
        WITH_VOLUME,
        Kind::IdentityConfirmed,
        When::OtherVolume,
        Some(Loaded),
        &[Fact::Identity(Identity::NotAsked), Fact::CheckWithdrawn],
    ),
    row(
        WITH_VOLUME,
        Kind::IdentityRejected,
        When::Always,
        Some(Loaded),
        &[Fact::Identity(Identity::Rejected), Fact::CheckWithdrawn],
    ),
    row(
        &[Confirmed],
        Kind::Calibration,
        When::Valid,
        Some(Calibrated),
        CALIBRATION,
    ),
    row(
        &[Loaded],
        Kind::Calibration,
        When::ValidInResearch,
        Some(Calibrated),
        CALIBRATION,
    ),
    row(AFTER_CONFIRMED, Kind::Calibration, When::SameCalibration, None, &[]),
    row(&[Calibrated], Kind::Calibration, When::Valid, None, CALIBRATION),
    row(
        AFTER_CALIBRATED,
        Kind::Calibration,
        When::Valid,
        Some(Registered),
        &[Fact::Calibration, Fact::CheckWithdrawn],
    ),
    row(
        AFTER_CONFIRMED,
        Kind::Calibration,
        When::InvalidOfConfirmed,
        Some(Confirmed),
        WITHDRAWN,
    ),
    row(
        AFTER_CONFIRMED,
        Kind::Calibration,
        When::Invalid,
        Some(Loaded),
        WITHDRAWN,
    ),
    // Too early, but known by its number from now on: bumped before its turn comes, it is bumped when it comes.
    row(
        &[Loaded, Confirmed],
        Kind::Registration,
        When::SameRegistration,
        None,
        &[],
    ),
    row(
        &[Loaded, Confirmed],
        Kind::Registration,
        When::WithinGates,
        None,
        REGISTRATION,
    ),
    row(AFTER_CALIBRATED, Kind::Registration, When::SameRegistration, None, &[]),
    // The same that was bumped or failed its check is no better for being told again.
    row(
        &[Calibrated],
        Kind::Registration,
        When::SameRegistration,
        Some(Registered),
        &[],
    ),
    // Of another registration nothing is known yet, neither good nor bad.
    row(
        AFTER_CONFIRMED,
        Kind::Registration,
        When::WithinGates,
        Some(Registered),
        REGISTRATION,
    ),
    row(
        AFTER_CONFIRMED,
        Kind::Registration,
        When::Always,
        Some(Calibrated),
        WITHDRAWN,
    ),
    row(
        AFTER_CALIBRATED,
        Kind::ReferenceBumped,
        When::Always,
        Some(Registered),
        &[Fact::Check(Check::Bumped)],
    ),
    // Remembered while the registration is out of use: it may be told again.
    row(
        ALL,
        Kind::ReferenceBumped,
        When::Always,
        None,
        &[Fact::Check(Check::Bumped)],
    ),
    row(AFTER_CALIBRATED, Kind::CheckDone, When::Fails, Some(Registered), FAILED),
    row(ALL, Kind::CheckDone, When::Fails, None, FAILED),
    row(&[Registered], Kind::CheckDone, When::Passes, Some(Checked), PASSED),
    row(AFTER_REGISTERED, Kind::CheckDone, When::Passes, None, PASSED),
    row(
        AFTER_REGISTERED,
        Kind::CheckDone,
        When::TooOld,
        Some(Registered),
        WITHDRAWN,
    ),
    row(
        AFTER_REGISTERED,
        Kind::CheckAge,
        When::GrownOld,
        Some(Registered),
        WITHDRAWN,
    ),
    row(AFTER_REGISTERED, Kind::CheckAge, When::Always, None, &[]),
    row(
        &[Loaded, Confirmed, Calibrated, Registered],
        Kind::PlanChanged,
        When::Always,
        None,
        &[],
    ),
    row(&[Checked], Kind::PlanChanged, When::Always, Some(Registered), WITHDRAWN),
    row(&[Checked], Kind::Start, When::IsFresh, Some(Navigating), &[]),
    row(&[Checked], Kind::Start, When::Always, Some(Registered), WITHDRAWN),
    row(&[Registered], Kind::Start, When::Unchecked, Some(Navigating), &[]),
    row(&[Navigating], Kind::Stop, When::IsPassed, Some(Checked), &[]),
    row(&[Navigating], Kind::Stop, When::Always, Some(Registered), &[]),
    row(ALL, Kind::ToolLost, When::Always, None, &[Fact::Tool(false)]),
    row(ALL, Kind::ToolSeen, When::Always, None, &[Fact::Tool(true)]),
    row(ALL, Kind::ImagesOld, When::Always, None, &[]),
    row(ALL, Kind::WindowRestarted, When::Always, None, &[]),
];

/// The table, a row a line: `CHECKED | Start | check passed, young enough -> NAVIGATING`.
pub fn in_words() -> String {
    let mut text = String::new();
    for row in TABLE {
        let from: Vec<&str> = row.from.iter().map(|stage| stage.word()).collect();
        let to = row.to.map_or("the same", Stage::word);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{} | {:?} | {} -> {to}", from.join(", "), row.at, row.when.word());
    }
    text
}
