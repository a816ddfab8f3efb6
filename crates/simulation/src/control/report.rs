//! What a search found, or why it found nothing.

/// The signs of the eigenvalues of the second derivatives at the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stability {
    /// Directions in which the energy falls: 0 at a minimum.
    pub falling: usize,
    /// Directions in which it neither rises nor falls, to 1e-12 of the largest stiffness, as a ring that may roll.
    pub neutral: usize,
}

/// A stationary state, certified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Minimum {
    /// The energy.
    pub energy: f64,
    /// The largest free force.
    pub residual: f64,
    /// The largest outer force or reaction, which the residual is measured by.
    pub load: f64,
    /// What rounding may leave of a free force: 8 times 2^-52 of stiffness times length, the largest of all. Solids of 1e7 and more times the
    /// stiffness that their loads ask for have no smaller forces.
    pub rounding: f64,
    /// Minimum or saddle.
    pub stability: Stability,
    /// The least determinant of a deformation gradient: above 0.
    pub least_determinant: f64,
    /// Steps made.
    pub iterations: usize,
    /// Energies computed, with or without derivatives.
    pub evaluations: usize,
    /// Matrices factored.
    pub factorisations: usize,
    /// Steps that needed the convex matrix.
    pub projected: usize,
}

/// Why no state was returned.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Failed {
    /// The start has no energy.
    #[error("the start has no energy: an element is turned inside out, solids overlap, or a number is not finite")]
    NoEnergy,
    /// The energy has no lower bound that the search could find.
    #[error(
        "no equilibrium exists near: after {iterations} steps the state is {distance:.2e} away, {extents:.0} times the largest solid, and the energy falls on"
    )]
    Unbounded {
        /// Steps made.
        iterations: usize,
        /// The largest parameter.
        distance: f64,
        /// The same in sizes of the largest solid.
        extents: f64,
    },
    /// Whether the state is a minimum cannot be said.
    #[error("the stiffness has no factor near any of four shifts: whether the state is a minimum is not known")]
    NoInertia,
    /// The steps ran out, or became too small to change the energy.
    #[error(
        "no convergence in {iterations} steps: the largest free force is {residual:.2e}, the largest load {load:.2e}"
    )]
    NotConverged {
        /// Steps made.
        iterations: usize,
        /// The largest free force.
        residual: f64,
        /// The largest load.
        load: f64,
    },
    /// The state found is no state of a solid.
    #[error(
        "the forces balance in a state that is turned inside out (least determinant {least_determinant:.3e}), which no solid can be"
    )]
    Inverted {
        /// The least determinant.
        least_determinant: f64,
    },
}

/// What a search has cost so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Work {
    pub(super) iterations: usize,
    pub(super) evaluations: usize,
    pub(super) factorisations: usize,
    /// Steps whose true matrix was not positive definite.
    pub(super) projected: usize,
    /// Saddles that were left.
    pub(super) saddles: usize,
}
