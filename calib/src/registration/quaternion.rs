//! Unit quaternions as arrays (w, x, y, z), and Horn's 4 x 4 matrix.

use nalgebra::{Matrix3, Matrix4, Vector3};

use super::jacobi::symmetric4;

/// (w, x, y, z).
pub(super) type Quaternion = [f64; 4];

/// Divides by the norm; the caller knows that it is neither zero nor extreme.
#[inline]
pub(super) fn unit(q: Quaternion) -> Quaternion {
    let [w, x, y, z] = q;
    let n = w * w + x * x + y * y + z * z;
    let off = n - 1.0;
    // The next term of the series, 3/8 off^2, is below a quarter ulp here.
    let scale = if off.abs() < 1e-8 {
        1.0 - 0.5 * off
    } else {
        1.0 / n.sqrt()
    };
    [w * scale, x * scale, y * scale, z * scale]
}

/// The rotation matrix of a unit quaternion (thesis, section 2.5.1).
#[inline]
pub(super) fn matrix(q: &Quaternion) -> Matrix3<f64> {
    let [w, x, y, z] = *q;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (x * y, x * z, y * z);
    let (wx, wy, wz) = (w * x, w * y, w * z);
    Matrix3::new(
        1.0 - 2.0 * (yy + zz),
        2.0 * (xy - wz),
        2.0 * (xz + wy),
        2.0 * (xy + wz),
        1.0 - 2.0 * (xx + zz),
        2.0 * (yz - wx),
        2.0 * (xz - wy),
        2.0 * (yz + wx),
        1.0 - 2.0 * (xx + yy),
    )
}

/// The quaternion of a nearly orthonormal matrix by the largest component (2.36, 2.37); `None` where it has no length
/// or is not finite.
#[inline]
pub(super) fn from_matrix(m: &Matrix3<f64>) -> Option<Quaternion> {
    let (a, b, c) = (m[(0, 0)], m[(1, 1)], m[(2, 2)]);
    let squares = [1.0 + a + b + c, 1.0 + a - b - c, 1.0 - a + b - c, 1.0 - a - b + c];
    let (p, q, r) = (m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
    let (s, t, u) = (m[(1, 0)] + m[(0, 1)], m[(0, 2)] + m[(2, 0)], m[(2, 1)] + m[(1, 2)]);
    // Each row is the quaternion times four times its largest component, so that no difference of near numbers is the
    // whole of it: w^2 >= 1/4 needs no search, and else one of the others is at least 1/2 in size.
    let raw = if squares[0] >= 1.0 {
        [squares[0], p, q, r]
    } else if a >= b && a >= c {
        [p, squares[1], s, t]
    } else if b >= c {
        [q, s, squares[2], u]
    } else {
        [r, t, u, squares[3]]
    };
    let norm = raw.iter().map(|x| x * x).sum::<f64>();
    (norm.is_finite() && norm > 0.0).then(|| unit(raw))
}

/// `Lambda_omega` of 4.28, by the blocks of 4.29.
pub(super) fn horn_matrix(psi: &Matrix3<f64>) -> Matrix4<f64> {
    let (g, t) = (gamma(psi), psi.trace());
    let block = psi + psi.transpose() - Matrix3::identity() * t;
    let mut m = Matrix4::identity() * t;
    m.fixed_view_mut::<3, 3>(1, 1).copy_from(&block);
    m.fixed_view_mut::<3, 1>(1, 0).copy_from(&g);
    m.fixed_view_mut::<1, 3>(0, 1).copy_from(&g.transpose());
    m
}

/// The vector `Gamma` of the skew part of `Psi` (4.12).
pub(super) fn gamma(psi: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(
        psi[(2, 1)] - psi[(1, 2)],
        psi[(0, 2)] - psi[(2, 0)],
        psi[(1, 0)] - psi[(0, 1)],
    )
}

/// Horn 1987: the eigenvector of 4.28 of the largest eigenvalue.
pub(super) fn horn(psi: &Matrix3<f64>) -> Quaternion {
    let (values, vectors) = symmetric4(horn_matrix(psi));
    let best = values.imax();
    unit(vectors.column(best).into_owned().into())
}

/// Faugeras and Hebert 1986: the eigenvector of `Lambda_epsilon` of the least eigenvalue.
///
/// By 4.30, with the centred clouds of the errata, `Lambda_epsilon = (tr A + tr B) I - 2 Lambda_omega`: the
/// eigenvectors are Horn's. It is formed here from the moments, not by the sum 4.25 over the points, which costs more
/// and is no better. Clouds of unequal size are brought to the same first, so that the shift is twice the root of the
/// product of their energies, the least it can be.
pub(super) fn faugeras_hebert(psi: &Matrix3<f64>, energy: f64) -> Quaternion {
    // `energy` is twice the root of the product of both energies, in the units of `psi`.
    let epsilon = Matrix4::identity() * energy - horn_matrix(psi) * 2.0;
    let (values, vectors) = symmetric4(epsilon);
    let best = values.imin();
    unit(vectors.column(best).into_owned().into())
}
