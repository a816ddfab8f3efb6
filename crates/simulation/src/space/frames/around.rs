//! What points of a surface may touch: the tube, and bones that do not move.

use nalgebra::Vector3;

use crate::space::term::{ObstacleContact, Rigid};
use crate::space::tube::{Distance, Tube};

/// The tube, and the bones behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) tube: &'a Tube,
    pub(super) bones: &'a [ObstacleContact],
}

impl Around<'_> {
    /// What has this number: 0 is the tube, the bones follow.
    pub(super) fn rigid(&self, number: usize) -> &dyn Rigid {
        // Numbers are those that points were given with the bones at hand.
        let bone = number.checked_sub(1).and_then(|k| self.bones.get(k));
        bone.map_or(self.tube as &dyn Rigid, |bone| bone.rigid())
    }

    /// The distance of a place to what has this number.
    pub(super) fn distance(&self, number: usize, at: &Vector3<f64>) -> Distance {
        self.rigid(number).signed_distance(at)
    }

    /// A lower bound of that.
    pub(super) fn clearance(&self, number: usize, at: &Vector3<f64>) -> f64 {
        self.rigid(number).clearance(at)
    }

    /// The same, left out where it is certainly above `most`; not where it is no number.
    pub(super) fn within(&self, number: usize, at: &Vector3<f64>, most: f64) -> Option<Distance> {
        let rigid = self.rigid(number);
        let clearance = rigid.clearance(at);
        (clearance <= most || clearance.is_nan()).then(|| rigid.signed_distance(at))
    }
}
