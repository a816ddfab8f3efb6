//! Constraints: what they add to the energy, and how far a step may go (II 3.3).
//!
//! Links and half-planes are exact: multipliers and a quadratic term, which is raised until multipliers settle
//! (augmented Lagrangian). Solids against solids, and against half-planes where many contacts change, are held apart by a
//! barrier that begins at a small distance, and no step is longer than what a bound of the motion proves free of contact.

mod advance;
mod barrier;
mod guard;
mod link;
mod nearest;
mod overlap;
mod pairs;
mod plane;
mod rows;
mod shape;

pub use barrier::barrier;
pub use guard::Guard;
pub use link::{End, Link};
pub use nearest::{Nearest, nearest};
pub use overlap::{Overlap, overlapping};
pub use pairs::Pairs;
pub use plane::Plane;

use nalgebra::Vector2;

use crate::sparse::Triplets;
use crate::system::Bodies;

/// How far a term is from what it stands for, after a search with it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Change {
    /// The largest change of a force of the constraint: zero when multipliers have settled.
    pub force: f64,
    /// The largest violation, a length.
    pub violation: f64,
    /// The term itself changed: search again whatever the numbers.
    pub again: bool,
}

impl Change {
    /// The worse of both.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            force: self.force.max(other.force),
            violation: self.violation.max(other.violation),
            again: self.again || other.again,
        }
    }
}

/// A contact or a link at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Force {
    /// The solid.
    pub body: usize,
    /// Where.
    pub point: Vector2<f64>,
    /// The force on the solid.
    pub force: Vector2<f64>,
    /// The distance to what is touched: zero at an exact contact.
    pub gap: f64,
}

/// A term of the energy of a system. Positions enter it through the boundaries of the solids only.
pub trait Term: std::fmt::Debug {
    /// Its energy; `None` where it has none.
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64>;

    /// Its energy, and its derivatives *added* to `gradient`.
    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64>;

    /// Its second derivatives, added to `sink`; where `convex`, of a positive semidefinite matrix near them.
    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()>;

    /// The part of `step`, at most 1, that may be made without passing through anything.
    fn reach(&self, _bodies: &Bodies, _a: &[f64], _step: &[f64]) -> f64 {
        1.0
    }

    /// Takes the state found as the next start: new multipliers, new cursors, a narrower barrier.
    fn update(&mut self, _bodies: &Bodies, _a: &[f64]) -> Change {
        Change::default()
    }

    /// The forces at work.
    fn forces(&self, _bodies: &Bodies, _a: &[f64]) -> Vec<Force> {
        Vec::new()
    }
}
