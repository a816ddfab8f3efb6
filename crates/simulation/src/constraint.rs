//! Constraints: what they add to the energy, and how far a step may go (II 3.3).
//!
//! Links and half-planes are exact: multipliers and a quadratic term, which is raised until multipliers settle
//! (augmented Lagrangian). Solids against solids, and against half-planes where many contacts change, are held apart by a
//! barrier that begins at a small distance, and no step is longer than what a bound of the motion proves free of contact.
//!
//! # Contact, file by file
//!
//! * `contact`: what all contacts have in common, and `continuation`: the one place that knows where a contact stands on its way
//!   from barrier or multipliers ([`Stage`]) to exact contact.
//! * `broad_phase` finds arcs that are near one another by boxes sorted along one axis, `ccd_pairs` those that a step must keep
//!   apart by swept boxes, `separating_lines` the lines that prove it, `ccd` how far a step may go (conservative advancement).
//! * `collision_pairs`: which solids keep out of which. `samples`: which points of a boundary stand for it, before and in exact
//!   contact.
//! * `exact`: rows of exact contact. `exact/central_path` lets forces end at the depth of the rows, `exact/wall` keeps out of a
//!   half-plane what has no row yet.
//! * `overlap` proves, independently of the rows of exact contact, that no solid lies in another, which is what results are checked and
//!   certified with: arcs against arcs cut until apart or together (`cell`, `meet`), and the turns of a boundary round one point
//!   of each run between contacts (`run`, `winding`).
//! * `last_state`: energy, gradient and second derivatives ask for the same state one after the other, which is looked at once.

mod barrier;
mod broad_phase;
mod ccd;
mod ccd_pairs;
mod collision_pairs;
mod contact;
mod continuation;
mod exact;
mod half_plane;
mod half_plane_barrier;
mod last_state;
mod link;
mod near;
mod nearest;
mod overlap;
mod rows;
mod samples;
mod separating_lines;
mod shape;
mod signed;
mod solid_barrier;

pub use barrier::barrier;
pub use broad_phase::near_boxes;
pub use continuation::{Continuation, Stage};
pub use half_plane::HalfPlane;
pub use half_plane_barrier::HalfPlaneBarrier;
pub use link::{End, Link};
pub use nearest::{Nearest, nearest};
pub use overlap::{Intersections, Overlap, Touching, deepest, intersections, overlapping};
pub use solid_barrier::SolidBarrier;

use nalgebra::Vector2;

use crate::bodies::Bodies;
use crate::sparse::Triplets;

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

/// How far the rows of an exact contact are from their solution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Sum of forces times gaps.
    pub work: f64,
    /// The rows, each by the part of the aim that it has: 1 at a small gap, 0 where it is out of reach.
    pub rows: f64,
    /// The largest force times gap.
    pub complementarity: f64,
    /// The largest force.
    pub largest: f64,
    /// The largest depth by which a row is violated: a length.
    pub violation: f64,
    /// Some row has next to no gap and next to no force.
    pub undecided: bool,
}

impl Progress {
    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            work: self.work + other.work,
            rows: self.rows + other.rows,
            complementarity: self.complementarity.max(other.complementarity),
            violation: self.violation.max(other.violation),
            largest: self.largest.max(other.largest),
            undecided: self.undecided || other.undecided,
        }
    }
}

/// Constraints whose forces are unknowns of their own: what the last steps to exact contact work on.
pub trait Active: std::fmt::Debug {
    /// Forces times gaps that the next step aims at; `None`: gradients are those of the forces as they are.
    fn aim(&mut self, work: Option<f64>);

    /// Rows of a solution begin anew at an aim far above what it has of force times gap: each slack rises to what its force leaves
    /// of the aim, and no step ends at once at a gap of next to nothing.
    fn recentre(&mut self, _work: f64) {}

    /// The parts of the Newton step `step` from `a`, at most 1, after which gaps and forces are still above zero.
    fn limits(&mut self, bodies: &Bodies, a: &[f64], step: &[f64]) -> [f64; 2];

    /// Gaps and forces follow their parts of the step that [`Self::limits`] saw last.
    fn take(&mut self, parts: [f64; 2]);

    /// How far from its rows' solution the state `a` is, with gaps and forces at the part `part` of the step that [`Self::limits`] saw
    /// last: `(- w sum ln s, sum |g - s|, the largest force)`. `None` where a row has lost its foot.
    fn merit(&self, _bodies: &Bodies, _a: &[f64], _part: f64) -> Option<[f64; 3]> {
        Some([0.0; 3])
    }

    /// Looks at the rows in a new state, and which there are; where `between`, adds rows where solids come closer between them
    /// too.
    fn review(&mut self, bodies: &Bodies, a: &[f64], between: bool) -> Progress;
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

    /// The forces at work.
    fn forces(&self, _bodies: &Bodies, _a: &[f64]) -> Vec<Force> {
        Vec::new()
    }
}

/// A term with what becomes of it from search to search.
pub trait Constraint: Term + Send + Sync {
    /// Where it stands.
    fn stage(&self) -> Stage {
        Stage::Final
    }

    /// Takes the state found as the next start: new multipliers, new cursors, a narrower barrier, exact contact.
    fn update(&mut self, _bodies: &Bodies, _a: &[f64]) -> Change {
        Change::default()
    }

    /// Its way to exact contact, where it has one.
    fn way_to_exact(&mut self) -> Option<&mut Continuation> {
        None
    }

    /// Its rows, where its forces are unknowns of their own now.
    fn rows(&mut self) -> Option<&mut dyn Active> {
        None
    }

    /// Moves a wall along its normal, in exact contact with all that it knows; nothing for what is none.
    fn move_wall(&mut self, _by: f64) {}

    /// A copy, to come back to.
    fn copy(&self) -> Box<dyn Constraint>;
}
