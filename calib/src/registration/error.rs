//! Why a set of pairs has no registration.

use std::fmt;

/// The singular values of `Psi`, divided by the root of the product of both clouds' mean squared radii: dimensionless.
///
/// `s1 >= s2 >= |s3|`; the third carries the sign of `det Psi`, negative where the best orthogonal map is a reflection.
/// Their sum is the correlation coefficient of the clouds at the best rotation: 1 for a perfect fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularValues(pub [f64; 3]);

impl SingularValues {
    /// `s1 / (s2 + s3)` with signed `s3`: radians of rotation per relative error of `Psi`. Infinite where no unique
    /// optimum exists; at least 0.5.
    pub fn condition(&self) -> f64 {
        let [s1, s2, s3] = self.0;
        let gap = s2 + s3;
        if gap > 0.0 { s1 / gap } else { f64::INFINITY }
    }
}

impl fmt::Display for SingularValues {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [s1, s2, s3] = self.0;
        write!(f, "relative singular values {s1:.3e}, {s2:.3e}, {s3:.3e}")
    }
}

/// Why a registration was refused. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The lists differ in length.
    #[error("{to} points in one frame cannot be paired with {from} in the other")]
    Unpaired {
        /// Points in `To`.
        to: usize,
        /// Points in `From`.
        from: usize,
    },
    /// There is not one weight, covariance or choice per pair.
    #[error("{found} {what} for {pairs} pairs: one per pair is needed")]
    Unmatched {
        /// What was counted, for instance `weights`.
        what: &'static str,
        /// How many came.
        found: usize,
        /// How many pairs there are.
        pairs: usize,
    },
    /// Fewer pairs (of weight above zero) than determine a transform.
    #[error("{found} pairs carry weight; at least {needed} are needed")]
    TooFew {
        /// Pairs with a weight above zero.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("pair {pair}: {found:?} holds a number that is not finite")]
    NotFinite {
        /// The first such pair.
        pair: usize,
        /// The point found.
        found: [f64; 3],
    },
    /// A weight is negative, NaN or infinite.
    #[error("pair {pair}: the weight {found} is not a finite number of at least 0")]
    BadWeight {
        /// The first such pair.
        pair: usize,
        /// The weight found.
        found: f64,
    },
    /// Every weight is zero.
    #[error("all {pairs} weights are zero")]
    NoWeight {
        /// The number of pairs.
        pairs: usize,
    },
    /// A covariance is not symmetric positive definite.
    #[error("pair {pair}: the covariance is not symmetric positive definite")]
    BadCovariance {
        /// The first such pair.
        pair: usize,
    },
    /// One cloud is a single point, to the resolution of its coordinates.
    #[error("the points coincide in one frame (root mean square radius {radius_mm:e} mm)")]
    Coincident {
        /// The smaller cloud's root mean square radius, mm.
        radius_mm: f64,
    },
    /// The pairs lie on a line: the rotation about it is free.
    #[error("the points lie on a line, so the rotation about it is undetermined ({0})")]
    Collinear(SingularValues),
    /// One cloud mirrors the other so evenly that several rotations are equally good.
    #[error("the clouds mirror each other and several rotations are equally good ({0})")]
    Reflected(SingularValues),
    /// The chosen method has no answer here though the problem has one.
    #[error("this method fails on these pairs ({0}); the default method does not")]
    MethodFails(SingularValues),
    /// No set of consistent pairs is large enough.
    #[error("the largest set of pairs that agree within {tolerance_mm} mm has {found} of {pairs}; {needed} are needed")]
    NoConsensus {
        /// Pairs in the largest consistent set.
        found: usize,
        /// The number of pairs.
        pairs: usize,
        /// The least number accepted.
        needed: usize,
        /// The tolerance of the comparison, mm.
        tolerance_mm: f64,
    },
    /// The search for consistent pairs was given up.
    #[error("the search for consistent pairs among {pairs} did not end within {steps} steps; tighten the tolerance")]
    SearchTooLong {
        /// The number of pairs.
        pairs: usize,
        /// The steps made.
        steps: usize,
    },
    /// An iteration did not settle.
    #[error("no convergence after {steps} steps (last step {last:e})")]
    NoConvergence {
        /// The steps made.
        steps: usize,
        /// Length of the last step, radians and radii.
        last: f64,
    },
}
