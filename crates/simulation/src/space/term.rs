//! Terms that links and contacts add to the energy. They see surfaces of solids only.

mod organ_contact;
mod pressures;
mod pulled;
mod rigid;
mod rigid_contact;
mod springs;

pub use organ_contact::OrganContact;
pub use pressures::BadStiffness;
pub(super) use pressures::depth_or_all;
pub use rigid::{ContactForce, Rigid};
pub use rigid_contact::{ObstacleContact, RigidContact, TubeContact, TubeForce};
pub use springs::Springs;

use super::bodies::Bodies;
use super::level_set::Unproved;
use crate::sparse::Triplets;

/// How far a term was from the state that it was brought up to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Change {
    /// The largest change of a force.
    pub force: f64,
    /// The deepest that a point is where it must not be, mm.
    pub depth: f64,
}

/// How a state fits what a contact can find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// The deepest that a point is where it must not be, mm.
    pub depth: f64,
    /// The widest gap between points of the surface at what they must stay out of, mm.
    pub gap: f64,
    /// The most that either may be, mm.
    pub deepest: f64,
    /// The deepest that a point inside the solid is where it must not be, mm: much only where something has come through the surface
    /// between its points. 0 where none is known.
    pub inside: f64,
    /// Why it is not proved that the surface has met nothing but what was looked at; `None` where that is.
    pub unproved: Option<Unproved>,
}

/// A point inside may be as deep as this part of [`Fit::deepest`] in a state that is found, which is a fifth of a radius: between points that
/// are as far apart as they may be a round surface dips by 0.13 of its radius.
pub(super) const MOST_INSIDE: f64 = 0.4;
/// A point of a surface may be as deep as this part of the radius of what it must stay out of, and no deeper: the way out must lead
/// back where it came from.
pub(super) const DEEPEST_PART: f64 = 0.5;

/// A term of the energy.
pub trait Term: std::fmt::Debug + Send + Sync {
    /// The energy; `None` where the state is not allowed.
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64>;

    /// The energy, and its derivatives added to `gradient`.
    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64>;

    /// The second derivatives, added to `sink`; where `convex`, of a positive semidefinite matrix near them.
    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()>;

    /// The part of `step`, at most 1, that may be made without passing through anything.
    fn reach(&self, _bodies: &Bodies, _a: &[f64], _step: &[f64]) -> f64 {
        1.0
    }

    /// The largest force at `a` on a point.
    fn reaction(&self, bodies: &Bodies, a: &[f64]) -> f64;

    /// True where [`Self::update`] may change its forces.
    fn changes(&self) -> bool {
        true
    }

    /// Takes the forces at `a` as those to go on from; how much that changed them.
    fn update(&mut self, _bodies: &Bodies, _a: &[f64]) -> Change {
        Change::default()
    }

    /// How the state fits what a contact can find; `None` of what is no contact.
    fn fit(&self, _bodies: &Bodies, _a: &[f64]) -> Option<Fit> {
        None
    }
}
