//! What a law answers, and the derivatives of the determinant that most laws share.

use nalgebra::{Matrix3, SMatrix, SVector};

/// A second-order tensor, column by column.
pub type Tensor = SVector<f64, 9>;
/// A linear map of such tensors, as `dP/dF`.
pub type Tangent = SMatrix<f64, 9, 9>;

/// Density, stress and tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// `w`, energy by reference volume (units of stress).
    pub density: f64,
    /// First Piola-Kirchhoff stress `P = dw/dF`.
    pub stress: Tensor,
    /// `dP/dF`, symmetric.
    pub tangent: Tangent,
}

/// A measure of the change of volume, zero at rest, with first derivative `tr dG` there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// Its value, dimensionless.
    pub theta: f64,
    /// `d theta / dF`.
    pub gradient: Tensor,
    /// The second derivative.
    pub hessian: Tangent,
}

/// The nine entries, column by column.
#[inline]
pub(crate) fn vector(m: &Matrix3<f64>) -> Tensor {
    Tensor::from_column_slice(m.as_slice())
}

/// `I + G`.
#[inline]
pub(super) fn deformation(g: &Tensor) -> Tensor {
    let mut f = *g;
    f[0] += 1.0;
    f[4] += 1.0;
    f[8] += 1.0;
    f
}

#[inline]
pub(super) fn trace(g: &Tensor) -> f64 {
    g[0] + g[4] + g[8]
}

/// The sum of the principal minors of order two.
#[inline]
fn second_invariant(g: &Tensor) -> f64 {
    (g[0] * g[4] - g[1] * g[3]) + (g[4] * g[8] - g[5] * g[7]) + (g[0] * g[8] - g[2] * g[6])
}

/// The cofactors of a matrix, column by column: the derivative of its determinant.
#[inline]
pub(super) fn cofactor(m: &Tensor) -> Tensor {
    // Columns of the cofactors are cross products of the columns.
    let [a, b, c] = [0, 3, 6];
    let cross = |p: usize, q: usize, k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        m[p + i] * m[q + j] - m[p + j] * m[q + i]
    };
    Tensor::from_fn(|entry, _| match entry / 3 {
        0 => cross(b, c, entry % 3),
        1 => cross(c, a, entry % 3),
        _ => cross(a, b, entry % 3),
    })
}

#[inline]
pub(super) fn determinant(m: &Tensor) -> f64 {
    m[0] * (m[4] * m[8] - m[5] * m[7]) + m[1] * (m[5] * m[6] - m[3] * m[8]) + m[2] * (m[3] * m[7] - m[4] * m[6])
}

/// `J - 1 = tr G + (second invariant of G) + det G`, without the cancellation of `det(I + G) - 1`.
#[inline]
pub(crate) fn excess(g: &Tensor) -> f64 {
    // Terms of first, second and third order: none holds a 1 that would swallow a small strain.
    trace(g) + second_invariant(g) + determinant(g)
}

/// `cof(I + G) - I = (tr G) I - G^T + cof G`.
#[inline]
pub(super) fn cofactor_excess(g: &Tensor) -> Tensor {
    let (mut c, t) = (cofactor(g), trace(g));
    // The linear part first: for small G it is the whole, and cof G adds its own order only.
    for row in 0..3 {
        for column in 0..3 {
            c[row + 3 * column] -= g[column + 3 * row];
        }
        c[4 * row] += t;
    }
    c
}

/// `|G|^2 - 2 (second invariant)`, the part of second order of `|F|^2 - 3 - 2 (J - 1)`.
#[inline]
pub(super) fn isochoric_square(g: &Tensor) -> f64 {
    let (xy, yz, zx) = (g[1] + g[3], g[5] + g[7], g[2] + g[6]);
    let (a, b, c) = (g[0], g[4], g[8]);
    // `a^2 + b^2 + c^2 - 2 (ab + bc + ca)`; where one is 0 it is the square of a difference, as in the plane.
    let stretches = (a - b) * (a - b) + c * (c - 2.0 * (a + b));
    // Shears enter as squares of sums, in which a small rotation drops out before it is squared.
    stretches + (xy * xy + yz * yz + zx * zx)
}

/// Adds `factor` times the second derivative of the determinant at `F`:
/// `d2 J / dF_iJ dF_kL = e_ikm e_JLN F_mN`.
pub(super) fn add_determinant_hessian(tangent: &mut Tangent, f: &Tensor, factor: f64) {
    for third in 0..3 {
        let (first, second) = ((third + 1) % 3, (third + 2) % 3);
        // Six signed entries of F fill each 3 x 3 block off the diagonal, all others are zero.
        for m in 0..3 {
            let (i, k) = ((m + 1) % 3, (m + 2) % 3);
            let value = factor * f[m + 3 * third];
            // `e_ikm` and `e_JLN` are both 1 for cyclic indices; each swap turns the sign.
            for (row, column, entry) in [
                (i + 3 * first, k + 3 * second, value),
                (k + 3 * first, i + 3 * second, -value),
            ] {
                tangent[(row, column)] += entry;
                tangent[(column, row)] += entry;
            }
        }
    }
}

/// `factor a a^T`.
#[inline]
pub(super) fn add_square(tangent: &mut Tangent, a: &Tensor, factor: f64) {
    for column in 0..9 {
        let scaled = factor * a[column];
        // Down each column, as the entries lie in memory.
        for row in 0..9 {
            tangent[(row, column)] += a[row] * scaled;
        }
    }
}
