//! What is rigid and must be stayed out of.

use nalgebra::Vector3;

use crate::space::level_set::{LevelSet, Unproved};
use crate::space::tube::{Distance, Tube};

/// Something rigid that points must stay out of.
pub trait Rigid: std::fmt::Debug + Send + Sync {
    /// Signed distance of a place, above zero outside, with two derivatives. No two places differ by more than the way between them.
    fn signed_distance(&self, x: &Vector3<f64>) -> Distance;

    /// A lower bound of it that costs less; below all numbers where none is known.
    fn clearance(&self, _x: &Vector3<f64>) -> f64 {
        f64::NEG_INFINITY
    }

    /// Why it is not proved that a point of a surface has met only what it is known to be like, on its way from where it was at rest: see
    /// [`LevelSet::unproved`].
    fn unproved(&self, _way: [&Vector3<f64>; 2], _most: f64, _gap: &dyn Fn() -> f64) -> Option<Unproved> {
        None
    }

    /// The radius of a ball that fits behind every point of its surface, mm.
    fn radius(&self) -> f64;

    /// What moments of the forces on it are about.
    fn centre(&self) -> Vector3<f64>;
}

impl Rigid for Tube {
    fn signed_distance(&self, x: &Vector3<f64>) -> Distance {
        Tube::signed_distance(self, x)
    }

    fn clearance(&self, x: &Vector3<f64>) -> f64 {
        self.distance(x)
    }

    fn radius(&self) -> f64 {
        self.least_radius()
    }

    fn centre(&self) -> Vector3<f64> {
        self.pose().translation.vector
    }
}

impl Rigid for LevelSet {
    fn signed_distance(&self, x: &Vector3<f64>) -> Distance {
        LevelSet::signed_distance(self, x)
    }

    fn clearance(&self, x: &Vector3<f64>) -> f64 {
        LevelSet::clearance(self, x)
    }

    fn unproved(&self, way: [&Vector3<f64>; 2], most: f64, gap: &dyn Fn() -> f64) -> Option<Unproved> {
        LevelSet::unproved(self, way, most, gap)
    }

    fn radius(&self) -> f64 {
        LevelSet::radius(self)
    }

    fn centre(&self) -> Vector3<f64> {
        Vector3::zeros()
    }
}

/// What the tissue does to something rigid, or to another organ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactForce {
    /// The sum of the forces on it.
    pub force: Vector3<f64>,
    /// Their moment, about the origin of a tube's own frame, or of all places.
    pub moment: Vector3<f64>,
    /// Points that press on it.
    pub points: usize,
    /// Area of the surface, in the reference configuration, that they stand for, mm^2.
    pub area: f64,
    /// The deepest point in it, mm; 0 where none is.
    pub depth: f64,
}
