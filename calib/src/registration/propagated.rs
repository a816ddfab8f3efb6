//! What errors that have directions, and a part that all pairs share, do to a registration by plain least squares.
//!
//! The error of pair i, turned to `To`, is `e_i = n_i + U_i z`: `n_i` of covariance `C_i` and of no other pair, `z` three
//! normal numbers of deviation 1 that are the same for all pairs, as the error of a pointer's tip is in all touches. With the
//! arms `y_i = R b'_i` about the centre, `J_i = (-[y_i]x, I)` and the weights `w_i` of the fit, to first order
//!
//! ```text
//! N = sum w_i J_i^T J_i,   S = sum w_i J_i^T U_i
//! G           = N^-1 S                                                                     what z moves the transform by
//! covariance  = N^-1 (sum w_i^2 J_i^T C_i J_i) N^-1 + G G^T                                                      (1)
//! chi-squared = min over m, z of sum (r_i - J_i m - U_i z)^T C_i^-1 (r_i - J_i m - U_i z) + z^T z                (2)
//! ```
//!
//! (1) holds for any errors, whatever the fit weighs: unlike that of a weighted fit it does not fall with the number of pairs
//! below what they share. (2) is chi-squared of `3 n - 6` degrees of freedom.

use geometry::{Frame, Point};
use nalgebra::{Matrix3, Matrix6, Matrix6x3, SMatrix, SVector, Vector3};

use super::pairs::coordinates;
use super::statistics::{carry, compliance, inertia, moved_to_origin, skew};
use super::{Fit, Pairs};

/// The error of a pair, in the axes of `From`. Noise of the point in `To` is in `own` too, where it is alike in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairError {
    /// Covariance of what is this pair's own, mm^2.
    pub own: Matrix3<f64>,
    /// What three normal numbers of deviation 1, the same for all pairs, move it by: a column for each, mm.
    pub shared: Matrix3<f64>,
}

impl PairError {
    /// Covariance of the whole error, mm^2.
    pub fn covariance(&self) -> Matrix3<f64> {
        self.own + self.shared * self.shared.transpose()
    }
}

/// What the errors of pairs make of the error of a transform, in the convention of [`super::Registration::covariance`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Propagated {
    /// Of all of it: (1).
    pub covariance: Matrix6<f64>,
    /// `G`: what the three numbers `z` that all pairs share move the true transform against the fitted one by. Whoever errs by the
    /// same `z` again, as a point touched with the same tip does, errs with it.
    pub shared: Matrix6x3<f64>,
}

impl Propagated {
    /// The same where the variances of what is each pair's own are `factor` times as large; what pairs share stays, as residuals do not show it.
    #[must_use]
    pub fn with_own_times(self, factor: f64) -> Self {
        let shared = self.shared * self.shared.transpose();
        Self {
            covariance: (self.covariance - shared) * factor + shared,
            ..self
        }
    }
}

/// Covariance (1) of a fit of `pairs` that have the errors `errors`, and what they share. `None` where the `From` cloud is a line to rounding.
///
/// `errors` must be as many as `pairs`: of others the surplus is passed over.
pub fn propagated<To: Frame, From: Frame>(
    fit: &Fit<To, From>,
    pairs: Pairs<'_, To, From>,
    errors: &[PairError],
) -> Option<Propagated> {
    let r = fit.rotation();
    let (inertia, _) = inertia(fit, pairs);
    let total: f64 = (0..pairs.len()).map(|i| pairs.weight(i)).sum();
    // About the centre turn and shift are apart: N^-1 is of two blocks.
    let mut inverse = Matrix6::identity() / total;
    let turn = compliance(&inertia)? / total;
    inverse.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
    let (mut own, mut shared) = (Matrix6::zeros(), Matrix6x3::zeros());
    for (i, (b, error)) in pairs.from.iter().zip(errors).enumerate() {
        // Arms of the fit's own pairs, turned: residuals change them in second order only.
        let (w, y) = (pairs.weight(i), r * fit.moments.centred(1, *b));
        let transposed = transposed(&y);
        own += transposed * (r * error.own * r.transpose()) * transposed.transpose() * (w * w);
        shared += transposed * (r * error.shared) * w;
    }
    // What is each pair's own adds up as squares, and what they share before it is squared.
    let at_centre = inverse * (own + shared * shared.transpose()) * inverse;
    let even = (at_centre + at_centre.transpose()) * 0.5;
    let centre = fit.moments.mean(0);
    Some(Propagated {
        covariance: moved_to_origin(even, &centre),
        shared: carry(&centre) * inverse * shared,
    })
}

/// Chi-squared (2) of the residuals of a fit; `None` where a `C_i` is not positive definite, or the pairs determine no motion.
pub fn chi_squared<To: Frame, From: Frame>(
    fit: &Fit<To, From>,
    pairs: Pairs<'_, To, From>,
    errors: &[PairError],
) -> Option<f64> {
    let r = fit.rotation();
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    let (mut pull, mut sum) = (SVector::<f64, 9>::zeros(), 0.0);
    // What all share was drawn once: without this it would be free, and explain anything.
    for k in 6..9 {
        normal[(k, k)] = 1.0;
    }
    for ((a, b), error) in pairs.to.iter().zip(pairs.from).zip(errors) {
        let y = r * fit.moments.centred(1, *b);
        let residual = fit.moments.centred(0, *a) - y;
        let weight = (r * error.own * r.transpose()).cholesky()?.inverse();
        let mut design = SMatrix::<f64, 3, 9>::zeros();
        design
            .fixed_view_mut::<3, 6>(0, 0)
            .copy_from(&transposed(&y).transpose());
        design.fixed_view_mut::<3, 3>(0, 6).copy_from(&(r * error.shared));
        normal += design.transpose() * weight * design;
        pull += design.transpose() * (weight * residual);
        sum += residual.dot(&(weight * residual));
    }
    // Rounding may leave a perfect fit below zero.
    Some((sum - pull.dot(&normal.cholesky()?.solve(&pull))).max(0.0))
}

/// Root mean square error at `target` of a transform of this covariance, mm.
pub fn rms_at<To>(covariance: &Matrix6<f64>, target: Point<To>) -> f64 {
    let transposed = transposed(&coordinates(target));
    (transposed.transpose() * covariance * transposed)
        .trace()
        .max(0.0)
        .sqrt()
}

/// `J^T = ([y]x; I)`.
fn transposed(y: &Vector3<f64>) -> Matrix6x3<f64> {
    let mut j = Matrix6x3::zeros();
    j.fixed_view_mut::<3, 3>(0, 0).copy_from(&skew(y));
    j.fixed_view_mut::<3, 3>(3, 0).copy_from(&Matrix3::identity());
    j
}
