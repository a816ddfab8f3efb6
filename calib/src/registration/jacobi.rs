//! Jacobi's method for small symmetric matrices and for the singular values of a 3 x 3 matrix.
//!
//! Slower than a tridiagonal reduction and more accurate: every rotation is orthogonal to the last place, and the
//! sweeps end only when nothing off the diagonal is left to turn.

use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3, Vector4};

/// Sweeps; convergence is quadratic and ten are never needed.
// A NaN is turned in every sweep and never becomes small: this bound ends it.
const MAX_SWEEPS: usize = 30;

/// The cosine and sine that diagonalise `[[p, off], [off, q]]` (Golub and Van Loan, 8.5.2): the smaller rotation.
fn rotation(p: f64, q: f64, off: f64) -> (f64, f64) {
    if off == 0.0 {
        return (1.0, 0.0);
    }
    // The root of least size of t^2 + 2 tau t - 1 = 0, in the form that does not cancel: a turn of at most 45 degrees,
    // without which the sweeps need not converge.
    let tau = (q - p) / (2.0 * off);
    let tangent = if tau >= 0.0 { 1.0 } else { -1.0 } / (tau.abs() + tau.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    (cosine, cosine * tangent)
}

/// Columns `p` and `q` of `m` become `c p - s q` and `s p + c q`.
fn turn_columns<const R: usize, const C: usize>(m: &mut SMatrix<f64, R, C>, [p, q]: [usize; 2], (c, s): (f64, f64)) {
    for i in 0..R {
        let (x, y) = (m[(i, p)], m[(i, q)]);
        m[(i, p)] = c * x - s * y;
        m[(i, q)] = s * x + c * y;
    }
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, unsorted.
fn symmetric<const N: usize>(mut m: SMatrix<f64, N, N>) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    let mut vectors = SMatrix::<f64, N, N>::identity();
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for p in 0..N {
            for q in p + 1..N {
                turned |= annihilate(&mut m, &mut vectors, [p, q]);
            }
        }
        if !turned {
            break;
        }
    }
    (SVector::from_fn(|i, _| m[(i, i)]), vectors)
}

/// Turns the entry (p, q) to zero; false where it already is nothing beside its diagonal.
fn annihilate<const N: usize>(
    m: &mut SMatrix<f64, N, N>,
    vectors: &mut SMatrix<f64, N, N>,
    [p, q]: [usize; 2],
) -> bool {
    let off = m[(p, q)];
    let size = m[(p, p)].abs().max(m[(q, q)].abs());
    // By Weyl's theorem no eigenvalue is off by more than the entry left: an eighth of an ulp of the larger diagonal.
    if off.abs() <= 0.125 * f64::EPSILON * size || off == 0.0 {
        return false;
    }
    let turn = rotation(m[(p, p)], m[(q, q)], off);
    turn_columns(m, [p, q], turn);
    // (M J)^T J = J^T M J for a symmetric M, which is symmetric again and so not transposed back.
    let mut transposed = m.transpose();
    turn_columns(&mut transposed, [p, q], turn);
    *m = transposed;
    // Rounding may leave more than the threshold here, which would be turned again in every sweep.
    m[(p, q)] = 0.0;
    m[(q, p)] = 0.0;
    turn_columns(vectors, [p, q], turn);
    true
}

/// Eigenvalues and eigenvectors of a symmetric 3 x 3 matrix, unsorted.
pub fn symmetric3(m: Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    symmetric(m)
}

/// Eigenvalues and eigenvectors of a symmetric 4 x 4 matrix, unsorted.
pub(crate) fn symmetric4(m: Matrix4<f64>) -> (Vector4<f64>, Matrix4<f64>) {
    symmetric(m)
}

/// Orthogonalises the columns of `m` from the right (Hestenes 1958): returns `(m V, V)` with `V` a rotation.
///
/// The columns of `m V` are the left singular vectors times the singular values, in no order.
pub(super) fn one_sided(mut m: Matrix3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    let mut v = Matrix3::identity();
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for pair in [[0, 1], [0, 2], [1, 2]] {
            turned |= orthogonalise(&mut m, &mut v, pair);
        }
        if !turned {
            break;
        }
    }
    (m, v)
}

/// Turns two columns until they are orthogonal; false where they are.
fn orthogonalise(m: &mut Matrix3<f64>, v: &mut Matrix3<f64>, [p, q]: [usize; 2]) -> bool {
    let (x, y) = (m.column(p), m.column(q));
    let (xx, yy, xy) = (x.norm_squared(), y.norm_squared(), x.dot(&y));
    // Two units: the scalar product itself is rounded by one and a half.
    if xy.abs() <= 2.0 * f64::EPSILON * (xx * yy).sqrt() || xy == 0.0 {
        return false;
    }
    // The turn that diagonalises the 2 x 2 Gram matrix, without forming Psi^T Psi, which squares the condition.
    let turn = rotation(xx, yy, xy);
    turn_columns(m, [p, q], turn);
    turn_columns(v, [p, q], turn);
    true
}
