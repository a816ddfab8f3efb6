//! The default solver: a closed start from the quartic of Horn's matrix, then Newton's method on the rotations.
//!
//! With `M = Psi R^T`, `R` is stationary where `M` is symmetric, and it is the global maximum of 4.13 exactly where `H
//! = tr(M) I - sym(M)` is positive semidefinite: turning on by `theta` about the unit axis `n` changes the criterion by
//! `-(1 - cos theta) n^T H n`. `H` is the matrix of Newton's step, so that the proof costs nothing. This is the
//! convergent form of the iteration that the thesis proposes in 4.40 and leaves open.

use nalgebra::{Matrix3, Vector3};

use super::quaternion::{Quaternion, from_matrix, matrix, unit};

/// Below this ratio of the least eigenvalue of `H` to its trace the singular value decomposition decides.
const MIN_GAP: f64 = 1e-9;
/// Newton steps; three are the most seen on well-posed sets.
const MAX_STEPS: usize = 8;
/// Steps on the quartic; two are usual, noise of the size of the cloud takes six.
const MAX_QUARTIC: usize = 12;

/// The last step on the quartic, beside its slope: a third of the digits, the steps on the rotations square the rest
/// away.
const QUARTIC_END: f64 = 1e-5;

/// The optimal rotation for `psi` of size about 1, or `None` where the optimum is too badly conditioned for this
/// method.
///
/// `bound` is at least `max tr(R^T psi)`, and the nearer the faster.
#[inline]
pub(super) fn solve(psi: &Matrix3<f64>, bound: f64) -> Option<Quaternion> {
    polish(psi, from_matrix(&start(psi, bound))?)
}

/// Newton's method from `q`. What it returns is stationary with `H` safely positive: the global optimum, whatever the
/// start.
#[inline]
pub(super) fn polish(psi: &Matrix3<f64>, mut q: Quaternion) -> Option<Quaternion> {
    for _ in 0..MAX_STEPS {
        let step = Step::at(psi, &matrix(&q))?;
        q = turned(&step.turn, &q);
        // The error left is of second order in the step, times the condition.
        if step.turn.norm_squared() <= f64::EPSILON * step.gap {
            return Some(q);
        }
    }
    None
}

/// True where `H` is safely positive definite at `q`, so that the optimum is unique and well determined.
#[inline]
pub(super) fn determined(psi: &Matrix3<f64>, q: &Quaternion) -> bool {
    Step::at(psi, &matrix(q)).is_some()
}

/// One Newton step and the least curvature it met.
struct Step {
    turn: Vector3<f64>,
    /// Between a third of and the whole least eigenvalue of `H`, relative to the trace of `H`.
    gap: f64,
}

impl Step {
    /// Solves `H turn = gradient` by cofactors; `None` where `H` is not safely positive definite.
    #[inline]
    fn at(psi: &Matrix3<f64>, r: &Matrix3<f64>) -> Option<Self> {
        let m = psi * r.transpose();
        let gradient = Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
        let (a, b, c) = (m[(1, 1)] + m[(2, 2)], m[(0, 0)] + m[(2, 2)], m[(0, 0)] + m[(1, 1)]);
        let d = -0.5 * (m[(1, 0)] + m[(0, 1)]);
        let e = -0.5 * (m[(2, 0)] + m[(0, 2)]);
        let f = -0.5 * (m[(2, 1)] + m[(1, 2)]);
        // Cofactors of [[a, d, e], [d, b, f], [e, f, c]].
        let (ca, cd, ce) = (b * c - f * f, e * f - d * c, d * f - e * b);
        let (cb, cf, cc) = (a * c - e * e, d * e - a * f, a * b - d * d);
        let det = a * ca + d * cd + e * ce;
        let minors = ca + cb + cc;
        // Sylvester's criterion on the trailing minors c, ca and det, the last with a margin. The margin alone would not
        // do: at a saddle `minors` or the trace may be negative, and so the bound. A NaN fails it.
        let positive = c > 0.0 && ca > 0.0 && det > 0.0 && det > MIN_GAP * minors * (a + b + c);
        if !positive {
            return None;
        }
        let [x, y, z] = gradient.into();
        let inverse = 1.0 / det;
        let turn = Vector3::new(
            ca * x + cd * y + ce * z,
            cd * x + cb * y + cf * z,
            ce * x + cf * y + cc * z,
        ) * inverse;
        // det / minors = 1 / (1/l1 + 1/l2 + 1/l3): between a third of and the whole least eigenvalue.
        let gap = det / (minors * (a + b + c));
        Some(Self { turn, gap })
    }
}

/// `exp(turn) * q` to third order in the turn, of unit norm.
#[inline]
fn turned(turn: &Vector3<f64>, q: &Quaternion) -> Quaternion {
    let [w, x, y, z] = *q;
    // (1, turn / 2) times q, normalised: no sine and cosine, as an error of third order vanishes with the steps.
    let [a, b, c] = (turn * 0.5).into();
    unit([
        w - (a * x + b * y + c * z),
        x + (a * w + b * z - c * y),
        y + (b * w + c * x - a * z),
        z + (c * w + a * y - b * x),
    ])
}

/// A rotation near the optimum: the largest root of the quartic of Horn's matrix by Newton's method from above, then
/// the attitude matrix in closed form (Markley 1993, FOAM). Exact up to the rounding of the root, whatever the angle.
#[inline]
fn start(psi: &Matrix3<f64>, bound: f64) -> Matrix3<f64> {
    // FOAM: R = ((kappa + |Psi|^2) Psi + lambda adj(Psi)^T - Psi Psi^T Psi) / (kappa lambda - det Psi), with kappa =
    // (lambda^2 - |Psi|^2) / 2 and lambda = tr(R^T Psi) at the optimum, the largest eigenvalue of 4.28.
    let cofactors = cofactors(psi);
    let det = psi[(0, 0)] * cofactors[(0, 0)] + psi[(0, 1)] * cofactors[(0, 1)] + psi[(0, 2)] * cofactors[(0, 2)];
    let square = psi.norm_squared();
    let lambda = largest_root(square, det, cofactors.norm_squared(), bound);
    let kappa = 0.5 * (lambda * lambda - square);
    let zeta = kappa * lambda - det;
    let cubic = psi * (psi.transpose() * psi);
    (psi * (kappa + square) + cofactors * lambda - cubic) * (1.0 / zeta)
}

/// The largest root of `(x^2 - square)^2 - 8 det x - 4 minors`, the characteristic polynomial of 4.28.
///
/// From above, Newton's method falls monotonically to the largest root of a polynomial whose roots are all real.
#[inline]
fn largest_root(square: f64, det: f64, minors: f64, bound: f64) -> f64 {
    let mut x = bound;
    for _ in 0..MAX_QUARTIC {
        let y = x * x - square;
        let value = y * y - 8.0 * det * x - 4.0 * minors;
        let slope = 4.0 * x * y - 8.0 * det;
        // A slope of zero makes x and all that follows from it NaN, which `from_matrix` refuses.
        let step = value / slope;
        x -= step;
        // Beside the distance to the second root, which the slope measures: a slender cloud needs the root closer.
        if step.abs() * x * x <= QUARTIC_END * slope.abs() {
            break;
        }
    }
    x
}

#[inline]
fn cofactors(m: &Matrix3<f64>) -> Matrix3<f64> {
    let row = |i: usize| Vector3::new(m[(i, 0)], m[(i, 1)], m[(i, 2)]);
    let (a, b, c) = (row(0), row(1), row(2));
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    Matrix3::new(bc.x, bc.y, bc.z, ca.x, ca.y, ca.z, ab.x, ab.y, ab.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `H` has the diagonal (-0.2, 1e-10, 0.6) there: the sum of its minors is negative, and so was the bound on `det`.
    #[test]
    fn a_saddle_is_no_determined_optimum() {
        let psi = Matrix3::from_diagonal(&Vector3::new(0.4, 0.2, -0.4 + 1e-10));
        assert!(!determined(&psi, &[1.0, 0.0, 0.0, 0.0]));
        assert!(determined(&psi.abs(), &[1.0, 0.0, 0.0, 0.0]));
    }
}
