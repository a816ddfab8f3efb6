//! The proof that a rotation is the global optimum.

use nalgebra::Matrix3;

use super::jacobi::symmetric3;
use super::quaternion::gamma;

/// What proves that no other rotation fits better.
///
/// With `M = Psi R^T`, `Psi` relative to the clouds' sizes: `R` is stationary where `M` is symmetric, and the global
/// maximum of 4.13 where moreover `tr(M) I - M` is positive semidefinite, for turning on by `theta` about `n` changes
/// the criterion by `-(1 - cos theta) n^T (tr(M) I - M) n`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// Norm of the skew part's vector of `M`: zero at a stationary rotation. Dimensionless.
    pub asymmetry: f64,
    /// The least eigenvalue of `tr(M) I - sym(M)`, equal to `s2 + s3` at the optimum. Dimensionless.
    pub least: f64,
}

impl Certificate {
    /// Rounding of `M`: three products of numbers below 1 and a rotation matrix good to 4 units, twelve entries' worth.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;

    pub(super) fn of(correlation: &Matrix3<f64>, rotation: &Matrix3<f64>) -> Self {
        let m = correlation * rotation.transpose();
        let h = Matrix3::identity() * m.trace() - (m + m.transpose()) * 0.5;
        let (values, _) = symmetric3(h);
        Self {
            asymmetry: gamma(&m).norm(),
            least: values.min(),
        }
    }

    /// True where the rotation is the global optimum, to the rounding of `M`.
    pub fn is_global(&self) -> bool {
        self.asymmetry <= Self::ROUNDING && self.least >= -Self::ROUNDING
    }

    /// An upper bound, to first order, of the angle in radians between the rotation and the optimum.
    pub fn error_bound_rad(&self) -> f64 {
        // Newton's step to the optimum is H^-1 gamma, at most |gamma| over the least eigenvalue; without one above zero
        // there is no bound, and the division says infinity.
        (self.asymmetry + Self::ROUNDING) / self.least.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registration::quaternion::matrix;

    /// At the identity this is optimal for a diagonal with positive sums of pairs.
    const PSI: Matrix3<f64> = Matrix3::new(0.6, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, -0.1);

    #[test]
    fn only_the_global_maximum_is_certified() {
        let best = Certificate::of(&PSI, &Matrix3::identity());
        assert!(
            best.is_global() && (best.least - 0.2).abs() < 4.0 * f64::EPSILON,
            "{best:?}"
        );
        // The three half-turns are stationary and not maximal.
        for half_turn in [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]] {
            let found = Certificate::of(&PSI, &matrix(&half_turn));
            assert!(found.asymmetry == 0.0 && !found.is_global(), "{found:?}");
        }
        let near = Certificate::of(&PSI, &matrix(&[1.0, 1e-12, 0.0, 0.0]));
        assert!(!near.is_global() && near.error_bound_rad() > 2e-12, "{near:?}");
    }
}
