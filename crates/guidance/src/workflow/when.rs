//! The conditions of the workflow's rows.

use super::event::Event;
use super::state::{Check, Identity, State};

/// When a row holds, beside its stage and its event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// Always.
    Always,
    /// The event's volume is the run's.
    SameVolume,
    /// The event's volume is another.
    OtherVolume,
    /// The calibration is valid.
    Valid,
    /// The calibration is valid, and the one that was accepted last.
    SameCalibration,
    /// The calibration is valid, the run is research, and nobody has ever rejected a volume.
    ValidInResearch,
    /// The calibration is not valid, the identity is confirmed.
    InvalidOfConfirmed,
    /// The calibration is not valid.
    Invalid,
    /// The registration is of the run's volume and within its gates.
    WithinGates,
    /// As [`When::WithinGates`], and the one that was told last.
    SameRegistration,
    /// The check is within its gate and young enough.
    Passes,
    /// The check is not within its gate.
    Fails,
    /// The check is older than it may be, or from the future.
    TooOld,
    /// The check was passed and is older than it may be.
    GrownOld,
    /// The check was passed and is young enough.
    IsFresh,
    /// The run is research, and nothing speaks against going on without a check.
    Unchecked,
    /// The check was passed.
    IsPassed,
}

impl When {
    /// Whether it holds.
    pub(super) fn holds(self, state: &State, event: &Event) -> bool {
        let volume = match *event {
            Event::VolumeLoaded { volume }
            | Event::IdentityConfirmed { volume }
            | Event::Registration { volume, .. } => Some(volume),
            _ => None,
        };
        let is_same = volume.is_some() && volume == state.volume;
        let is_valid = matches!(event, Event::Calibration { is_valid: true, .. });
        let is_known = match *event {
            Event::Calibration { id, .. } => state.calibration == Some(id),
            Event::Registration { id, .. } => state.registration == Some(id),
            _ => false,
        };
        let within = matches!(event, Event::Registration { is_within_gates, .. } if *is_within_gates);
        let passes = matches!(event, Event::CheckDone { worst_mm, .. } if state.rules.passes(*worst_mm));
        let is_fresh = match *event {
            Event::CheckDone { age_ns, .. } | Event::CheckAge { age_ns } => state.rules.is_fresh(age_ns),
            Event::Start { check_age_ns } => state.rules.is_fresh(check_age_ns),
            _ => false,
        };
        let is_passed = state.check == Check::Passed;
        match self {
            Self::Always => true,
            Self::SameVolume => is_same,
            Self::OtherVolume => !is_same,
            Self::Valid => is_valid,
            Self::SameCalibration => is_valid && is_known,
            Self::ValidInResearch => is_valid && state.is_research() && !state.was_rejected,
            Self::InvalidOfConfirmed => !is_valid && state.identity == Identity::Confirmed,
            Self::Invalid => !is_valid,
            Self::WithinGates => within && is_same,
            Self::SameRegistration => within && is_same && is_known,
            Self::Passes => passes && is_fresh,
            Self::Fails => !passes,
            Self::TooOld => !is_fresh,
            Self::GrownOld => is_passed && !is_fresh,
            Self::IsFresh => is_passed && is_fresh,
            Self::Unchecked => state.is_research() && state.check == Check::NotMade,
            Self::IsPassed => is_passed,
        }
    }

    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::Always => "always",
            Self::SameVolume => "of the same volume",
            Self::OtherVolume => "of another volume",
            Self::Valid => "valid",
            Self::SameCalibration => "valid, the same again",
            Self::ValidInResearch => "valid, research, no volume ever rejected",
            Self::InvalidOfConfirmed => "not valid, identity confirmed",
            Self::Invalid => "not valid",
            Self::WithinGates => "of the same volume, within gates",
            Self::SameRegistration => "of the same volume, within gates, the same again",
            Self::Passes => "within the gate, young enough",
            Self::Fails => "over the gate",
            Self::TooOld => "too old",
            Self::GrownOld => "passed, too old",
            Self::IsFresh => "check passed, young enough",
            Self::Unchecked => "research, nothing speaks against it",
            Self::IsPassed => "check passed",
        }
    }
}
