//! How far a run has come, as the pilot tells it.

use guidance::workflow::{Activity, Check, Identity, Mark, May, Stage, State, may};
use iceoryx2::prelude::ZeroCopySend;

/// What every screen has to say of the run's workflow. Published by the pilot, which keeps the state, whenever it changes.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/Workflow/3")]
pub struct Workflow {
    /// When it was said, ns on the session's clock.
    pub t_ns: i64,
    /// Place of the stage in [`Stage::ALL`].
    pub stage: u32,
    /// Bits: [`Workflow::RESEARCH`] and those after it.
    pub flags: u32,
    /// When the last point of the last check was touched, ns on the session's clock; of no meaning where `check_points` is 0.
    pub check_t_ns: i64,
    /// The largest distance of a point of it from its place, mm.
    pub check_worst_mm: f64,
    /// How many points were touched; 0: no check was made of the registration in use.
    pub check_points: u32,
    /// How often a person said that the marker on the patient was moved.
    pub bumps: u32,
}

const _: () = assert!(size_of::<Workflow>() == 40);

impl Workflow {
    /// Confirmations may be skipped: every screen says RESEARCH.
    pub const RESEARCH: u32 = 1;
    /// Sight, digits and verdict may be shown.
    pub const SIGHT: u32 = 2;
    /// What is shown is marked NOT CHECKED.
    pub const NOT_CHECKED: u32 = 4;
    /// A person has confirmed whose the examination is.
    pub const CONFIRMED: u32 = 8;
    /// A person says that the examination is not the patient's.
    pub const REJECTED: u32 = 16;
    /// The check failed.
    pub const CHECK_FAILED: u32 = 32;
    /// The marker on the patient was pushed.
    pub const BUMPED: u32 = 64;
    /// Images that follow the tool may be shown: with the sight, or under a mark.
    pub const IMAGES: u32 = 128;

    /// That of a state.
    pub fn of(state: &State, t_ns: i64) -> Self {
        let may_sight = may(state, Activity::Sight);
        let flag = |is: bool, flag: u32| if is { flag } else { 0 };
        let images = may(state, Activity::LiveImages) != May::No || state.stage() == Stage::Navigating;
        Self {
            t_ns,
            stage: Stage::ALL.iter().position(|stage| *stage == state.stage()).unwrap_or(0) as u32,
            flags: flag(state.is_research(), Self::RESEARCH)
                | flag(may_sight != May::No, Self::SIGHT)
                | flag(
                    state.skipped().check || state.check() != Check::Passed,
                    Self::NOT_CHECKED,
                )
                | flag(state.identity() == Identity::Confirmed, Self::CONFIRMED)
                | flag(state.identity() == Identity::Rejected, Self::REJECTED)
                | flag(state.check() == Check::Failed, Self::CHECK_FAILED)
                | flag(state.check() == Check::Bumped, Self::BUMPED)
                | flag(images, Self::IMAGES),
            ..Self::default()
        }
    }

    /// With the last check of the registration in use.
    #[must_use]
    pub const fn checked(self, worst_mm: f64, points: u32, t_ns: i64) -> Self {
        Self {
            check_t_ns: t_ns,
            check_worst_mm: worst_mm,
            check_points: points,
            ..self
        }
    }

    /// The stage, or `None` for an unknown code.
    pub fn stage(&self) -> Option<Stage> {
        Stage::ALL.get(self.stage as usize).copied()
    }

    /// Whether all of these bits are set.
    pub const fn has(&self, flags: u32) -> bool {
        self.flags & flags == flags
    }

    /// The marks that stand on what is shown.
    pub fn marks(&self) -> Vec<Mark> {
        let mut marks = Vec::new();
        if self.has(Self::NOT_CHECKED) && self.stage().is_some_and(|stage| stage >= Stage::Registered) {
            marks.push(Mark::NotChecked);
        }
        if self.stage() == Some(Stage::Checked) {
            marks.push(Mark::NotStarted);
        }
        marks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use guidance::workflow::{Event, Rules, VolumeId, step};

    #[test]
    fn what_is_told_is_the_state() {
        let volume = VolumeId([7; 32]);
        let mut state = State::new(Rules::new(false, 2.0, 1_000_000_000).unwrap());
        let told = Workflow::of(&state, 5);
        assert_eq!((told.stage(), told.t_ns), (Some(Stage::Empty), 5));
        assert!(told.has(Workflow::RESEARCH) && !told.has(Workflow::SIGHT) && !told.has(Workflow::IMAGES));
        for event in [
            Event::VolumeLoaded { volume },
            Event::Calibration { id: 1, is_valid: true },
            Event::Registration {
                id: 2,
                volume,
                is_within_gates: true,
            },
        ] {
            state = step(state, event).0;
        }
        let told = Workflow::of(&state, 5);
        assert_eq!(
            (told.stage(), told.marks()),
            (Some(Stage::Registered), vec![Mark::NotChecked])
        );
        assert!(told.has(Workflow::IMAGES) && !told.has(Workflow::SIGHT));
        state = step(state, Event::Start { check_age_ns: 0 }).0;
        state = step(state, Event::ToolSeen).0;
        let told = Workflow::of(&state, 5);
        assert_eq!(told.stage(), Some(Stage::Navigating));
        assert!(told.has(Workflow::IMAGES | Workflow::SIGHT | Workflow::NOT_CHECKED));
        assert!(!told.has(Workflow::CONFIRMED));
        state = step(state, Event::ToolLost).0;
        assert!(!Workflow::of(&state, 5).has(Workflow::SIGHT));
        let unknown = Workflow {
            stage: 99,
            ..Workflow::default()
        };
        assert_eq!(unknown.stage(), None);
    }
}
