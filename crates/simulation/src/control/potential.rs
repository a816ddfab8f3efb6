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

    /// The same step with its turns made whole: along a straight line what is stiff stretches by half the square of the angle that it turns by.
    /// `None` where that is nothing beside what it meets.
    fn turned(&self, _a: &[f64], _step: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// The unknowns that keep their value.
    fn fixed(&self) -> &[bool];

    /// The outer force on an unknown.
    fn load(&self, unknown: usize) -> f64;

    /// The largest force of a constraint at `a`: the scale of forces where there is no load.
    fn reaction(&self, _a: &[f64]) -> f64 {
        0.0
    }

    /// Stiffness times length, by unknown, for `sizes`: times 2^-52 the rounding of the gradient at `a`. None of them: not known.
    fn rounding(&self, _a: &[f64], sizes: &mut Vec<f64>) {
        sizes.clear();
    }

    /// The sum of the sizes of what the outer forces have done at `a`: energies that cancel nearly are known no better than
    /// to the rounding of that.
    fn work(&self, _a: &[f64]) -> f64 {
        0.0
    }

    /// The scale of lengths.
    fn extent(&self) -> f64;

    /// A scale of stiffness that constraints have no part in; infinite where none is known.
    fn stiffness(&self) -> f64 {
        f64::INFINITY
    }

    /// The stiffness of each unknown beside [`Self::stiffness`], for `parts`: what matrices are shifted by, so that what is soft is not held by a
    /// small part of what is stiff. None of them: all alike.
    fn relative_stiffness(&self, parts: &mut Vec<f64>) {
        parts.clear();
    }

    /// The least determinant of a deformation gradient; zero or less where something is turned inside out.
    fn least_determinant(&self, a: &[f64]) -> f64;
}
