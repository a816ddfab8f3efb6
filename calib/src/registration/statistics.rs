//! What the noise of the points does to the transform, to first order.
//!
//! Convention of every 6 x 6 covariance here: rows and columns are (rotation vector, translation), both in `To`,
//! radians and mm; the true transform is `p -> exp(w) (R p + t) + v` with the small `(w, v)` of this covariance,
//! turning about `To`'s origin.
//!
//! Covariances and errors square lengths: they are finite where lengths lie between about 1e-150 and 1e150 mm. The
//! transform and its residuals need no such limit.

use geometry::Point;
use nalgebra::{Matrix3, Matrix6, Vector3};

use super::pairs::coordinates;
use super::{Fit, Pairs};

/// Isotropic noise of a pair of mean weight: that of both points together, as seen in `To`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation along each axis, mm.
    pub sigma_mm: f64,
}

impl Noise {
    /// Root mean square length, mm: `sqrt(3) sigma`.
    pub fn fle_rms_mm(&self) -> f64 {
        self.sigma_mm * 3.0_f64.sqrt()
    }
}

/// Weighted mean of `x x^T` in `To` and the number of pairs of weight above zero.
pub(super) fn inertia<To, From>(fit: &Fit<To, From>, pairs: Pairs<'_, To, From>) -> (Matrix3<f64>, usize) {
    let rotation = fit.rotation();
    let (mut sum, mut total, mut count) = (Matrix3::zeros(), 0.0, 0);
    for (i, b) in pairs.from.iter().enumerate() {
        let w = pairs.weight(i);
        // The Jacobian's levers are the images R b', not the points seen: residuals do not lengthen them.
        let x = rotation * fit.moments.centred(1, *b);
        sum += x * x.transpose() * w;
        total += w;
        count += usize::from(w > 0.0);
    }
    (sum / total, count)
}

/// `[v]x`: the matrix of the vector product with `v`.
pub(super) fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

/// `(tr(inertia) I - inertia)^-1`: covariance of the rotation vector per `sigma^2 / N`. `None` for a line of points.
pub(super) fn compliance(inertia: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    // J^T J of a turn about the centre: sum [x]x^T [x]x = sum (|x|^2 I - x x^T), the tensor of inertia of the points.
    let h = Matrix3::identity() * inertia.trace() - inertia;
    h.cholesky().map(|c| c.inverse())
}

/// Mean squared displacement at `d` from the centre, in units of `sigma^2 / N`: `3 + sum d_k^2 / f_k^2` over the
/// principal axes (Fitzpatrick, West and Maurer 1998, equation 46), without forming the axes.
pub(super) fn displacement(compliance: &Matrix3<f64>, d: &Vector3<f64>) -> f64 {
    // In the principal axes C = diag(1 / f_k^2) and |d x e_k|^2 = d_k^2, so the trace is the sum; a trace is the same
    // in all axes.
    let lever = skew(d);
    3.0 + (lever * compliance * lever.transpose()).trace()
}

/// Carries a covariance at the point `c` to the origin: `v = v_c - w x c`.
pub(super) fn moved_to_origin(at_centre: Matrix6<f64>, c: &Vector3<f64>) -> Matrix6<f64> {
    let carry = carry(c);
    carry * at_centre * carry.transpose()
}

/// The same of a small motion itself.
pub(super) fn carry(c: &Vector3<f64>) -> Matrix6<f64> {
    let mut carry = Matrix6::identity();
    carry.fixed_view_mut::<3, 3>(3, 0).copy_from(&skew(c));
    carry
}

/// Root mean square target registration error at `target` for points at `points` of a rigid body, mm, from their
/// geometry alone (as [`super::Registration::predicted_tre_mm`]). Infinite for fewer than three points or points on a line.
pub fn predicted_tre_mm<F>(points: &[Point<F>], target: Point<F>, noise: Noise) -> f64 {
    if points.len() < 3 {
        return f64::INFINITY;
    }
    let n = points.len() as f64;
    let centre = points.iter().map(|p| coordinates(*p)).sum::<Vector3<f64>>() / n;
    let outer = |p: &Point<F>| {
        let x = coordinates(*p) - centre;
        x * x.transpose()
    };
    let inertia = points.iter().map(outer).sum::<Matrix3<f64>>() / n;
    // A line leaves a least moment of rounding size, which a Cholesky factor may still accept.
    let (moments, _) = super::jacobi::symmetric3(Matrix3::identity() * inertia.trace() - inertia);
    if moments.min() <= 64.0 * f64::EPSILON * moments.max() {
        return f64::INFINITY;
    }
    let d = coordinates(target) - centre;
    let squared = compliance(&inertia).map(|c| displacement(&c, &d) / n);
    squared.map_or(f64::INFINITY, |s| s.sqrt() * noise.sigma_mm)
}
