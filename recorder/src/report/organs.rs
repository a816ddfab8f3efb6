//! What a recording holds of organs that a model moved: its states, and by the run's own report the images that showed them.

use std::collections::BTreeMap;

use bus::message::{TissueShown, TissueState};
use serde::Serialize;

use super::run_report::Tissue;
use crate::wire::proto::TissueFrame;

/// The states so far.
#[derive(Debug, Default)]
pub(super) struct Organs {
    pub(super) states: BTreeMap<&'static str, u64>,
    largest: Option<Force>,
}

/// What tissue did to the tube.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Force {
    /// The capture of its pose, ns.
    pub(super) t_ns: i64,
    /// Its size, N, by the model.
    pub(super) newton: f64,
}

/// What is told of organs. Empty where the scene moves none.
#[derive(Debug, Default, Serialize)]
pub(super) struct OrganFacts {
    /// Recorded states, by how far they came.
    pub(super) states: BTreeMap<&'static str, u64>,
    /// The largest force on the tube among settled ones; `null`: there is none.
    pub(super) largest_force: Option<Force>,
}

impl Organs {
    /// Takes a state; why it is none, in words. Settled ones are held against `tolerance`.
    pub(super) fn take(&mut self, state: &TissueFrame, tolerance: f64) -> Result<(), String> {
        let header = &state.header;
        // What its own certificate denies is no state: no image was drawn by it.
        let found = header.certified(tolerance).map_err(|error| error.to_string())?;
        *self.states.entry(found.word()).or_default() += 1;
        let [x, y, z] = header.force;
        let newton = x.hypot(y).hypot(z);
        let is_more = self.largest.is_none_or(|largest| newton > largest.newton);
        if found == TissueState::Settled && is_more {
            let t_ns = header.t_capture_ns;
            self.largest = Some(Force { t_ns, newton });
        }
        Ok(())
    }

    /// What came of it.
    pub(super) fn finish(self) -> OrganFacts {
        OrganFacts {
            states: self.states,
            largest_force: self.largest,
        }
    }

    /// States that came so far.
    pub(super) fn count(&self, state: TissueState) -> u64 {
        self.states.get(state.word()).copied().unwrap_or(0)
    }
}

impl Tissue {
    /// First images of poses that showed this.
    pub(super) fn count(&self, shown: TissueShown) -> u64 {
        self.images.get(shown.word()).copied().unwrap_or(0)
    }

    /// All first images of poses.
    pub(super) fn all(&self) -> u64 {
        self.images.values().fold(0, |sum: u64, n| sum.saturating_add(*n))
    }

    /// First images of poses with organs where a model had them.
    pub(super) fn moved(&self) -> u64 {
        self.count(TissueShown::Settled)
            .saturating_add(self.count(TissueShown::Approximate))
    }
}
