//! What a run navigated without, however often its workflow changed.

use bus::message::Workflow;

/// The word of the stage at which a run navigates.
const NAVIGATING: &str = "NAVIGATING";

/// What held while the run was NAVIGATING, of all its changes, of which only the first are listed.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) struct Navigated {
    /// The run was there at all.
    pub(super) is_reached: bool,
    /// Flags that were ever set there.
    ever: u32,
    /// Flags that were ever missing there.
    missed: u32,
}

impl Navigated {
    /// Whether a flag of the workflow was ever set.
    pub(super) const fn ever(self, flag: u32) -> bool {
        self.ever & flag != 0
    }

    /// Whether it was ever not set.
    pub(super) const fn ever_without(self, flag: u32) -> bool {
        self.missed & flag != 0
    }

    /// Takes how far the run has come.
    pub(super) fn take(&mut self, workflow: &Workflow) {
        if workflow.stage().is_some_and(|stage| stage.word() == NAVIGATING) {
            self.is_reached = true;
            self.ever |= workflow.flags;
            self.missed |= !workflow.flags;
        }
    }
}
