//! Where organs are that were elsewhere in the CT: by the breath, or as the tube has moved them.

use geometry::{Ct, Point, Vector};

use crate::approach::Approached;
use crate::breathing::Breath;
use crate::tissue::Pushed;
use crate::truth::{Told, length};

/// What organs did on a way.
pub(super) enum Organs {
    AtRest,
    Breathe(Breath),
    Pushed(Pushed),
}

impl Organs {
    /// How far they have been moved at the told target since the CT; the outer `None`: nobody knows.
    pub(super) fn moved(&self, t_ns: i64) -> Option<Option<Vector<Ct>>> {
        match self {
            Self::AtRest => Some(None),
            Self::Breathe(breath) => Some(Some(breath.moved(t_ns as f64 / 1e9))),
            Self::Pushed(pushed) => pushed.truly.map(|[told, _]| Some(told)),
        }
    }

    /// From the true tip to where what was aimed at has gone when the operator lets go.
    pub(super) fn miss_mm(&self, done: &Approached, aimed: Point<Ct>) -> f64 {
        let moved = match self {
            Self::AtRest => return done.outcome.miss_mm,
            Self::Breathe(breath) => Some(breath.moved(done.ended_s)),
            Self::Pushed(pushed) => pushed.truly.map(|[_, aimed]| aimed),
        };
        moved.map_or(f64::NAN, |moved| done.outcome.tip.distance(aimed + moved))
    }

    pub(super) fn word(&self) -> &str {
        match self {
            Self::Pushed(pushed) => &pushed.word,
            _ => "",
        }
    }

    /// See [`crate::record::Row::model_numbers`].
    pub(super) fn model_numbers(&self, told: &Told) -> [f64; 4] {
        let (Self::Pushed(pushed), unknown) = (self, f64::NAN) else {
            return [f64::NAN; 4];
        };
        let Some(model) = &pushed.model else {
            return [unknown; 4];
        };
        let [radius_mm, nees] = model.stated.unwrap_or([unknown; 2]);
        // The tool is shown as ever, and the target where the model has it, in the place of where it was planned.
        let [_, .., organs] = told.links;
        let off = model.off.mm();
        let shown: [f64; 3] = std::array::from_fn(|k| told.error[k] - organs.found[k] - off[k]);
        [length(off), radius_mm, nees, length(shown)]
    }
}
