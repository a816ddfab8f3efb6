//! What control asks of a system.

use crate::sparse::Triplets;

/// An energy with two derivatives, and how far a step may go.
pub trait Potential {
    /// The number of unknowns.
    fn size(&self) -> usize;

    /// The energy; `None` where there is none.
    fn energy(&self, a: &[f64]) -> Option<f64>;

    /// The energy and its gradient, which is overwritten.
    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64>;

    /// The second derivatives, overwritten; where `convex`, of a positive semidefinite matrix near them.
    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()>;

    /// The part of `step`, at most 1, that may be made without passing through anything.
    fn reach(&self, _a: &[f64], _step: &[f64]) -> f64 {
        1.0
    }

    /// The unknowns that keep their value.
    fn fixed(&self) -> &[bool];

    /// The outer force on an unknown.
    fn load(&self, unknown: usize) -> f64;

    /// The scale of lengths.
    fn extent(&self) -> f64;

    /// A scale of stiffness that constraints have no part in; infinite where none is known.
    fn stiffness(&self) -> f64 {
        f64::INFINITY
    }

    /// The least determinant of a deformation gradient; zero or less where something is turned inside out.
    fn least_determinant(&self, a: &[f64]) -> f64;
}
