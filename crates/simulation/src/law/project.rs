//! The nearest positive semidefinite tangent of an isotropic law, in closed form.
//!
//! With the signed singular values `F = U diag(s1, s2) V^T` the tangent of an isotropic law in the plane falls into a
//! twist `U [[0, -1], [1, 0]] V^T`, a flip `U [[0, 1], [1, 0]] V^T` and a 2 x 2 block of scalings (Smith, de Goes and
//! Kim 2019): three independent sets of eigenvalues, each clamped by itself.

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

/// `F = U diag(s1, s2) V^T` with rotations `U` and `V`; `s2` carries the sign of `det F`, and `s1 >= |s2|`.
pub fn signed_svd(f: &Matrix2<f64>) -> (Matrix2<f64>, Vector2<f64>, Matrix2<f64>) {
    // F is the sum of a similitude and an anti-similitude: two complex numbers.
    let (p, q) = (0.5 * (f[(0, 0)] + f[(1, 1)]), 0.5 * (f[(1, 0)] - f[(0, 1)]));
    let (r, t) = (0.5 * (f[(0, 0)] - f[(1, 1)]), 0.5 * (f[(1, 0)] + f[(0, 1)]));
    // Singular values are the sum and the difference of the two lengths, rotations half the sum and difference of their
    // angles.
    let (even, odd) = (p.hypot(q), r.hypot(t));
    let (turn, mirror) = (q.atan2(p), t.atan2(r));
    let rotation = |angle: f64| {
        let (s, c) = angle.sin_cos();
        Matrix2::new(c, -s, s, c)
    };
    let left = rotation(0.5 * (turn + mirror));
    let right = rotation(0.5 * (mirror - turn));
    (left, Vector2::new(even + odd, even - odd), right)
}

/// The eigenvalues of an isotropic tangent, and the tensors they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modes {
    /// Twist, flip, and the two scalings, in units of stress.
    pub values: [f64; 4],
    vectors: [Vector4<f64>; 4],
}

impl Modes {
    /// The modes of the isotropic tangent `a` at the gradient `f`.
    pub fn of(a: &Matrix4<f64>, f: &Matrix2<f64>) -> Self {
        let (u, _, v) = signed_svd(f);
        let dyad = |i: usize, j: usize| {
            let (u, v) = (u.column(i), v.column(j));
            Vector4::new(u[0] * v[0], u[1] * v[0], u[0] * v[1], u[1] * v[1])
        };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let (twist, flip) = ((dyad(1, 0) - dyad(0, 1)) * half, (dyad(1, 0) + dyad(0, 1)) * half);
        let (d1, d2) = (dyad(0, 0), dyad(1, 1));
        let form = |x: &Vector4<f64>, y: &Vector4<f64>| x.dot(&(a * y));
        let (a11, a12, a22) = (form(&d1, &d1), form(&d1, &d2), form(&d2, &d2));
        // Of the 2 x 2 block of scalings; twist and flip are eigenvectors already.
        let angle = 0.5 * (2.0 * a12).atan2(a11 - a22);
        let (s, c) = angle.sin_cos();
        let (mean, half_gap) = (0.5 * (a11 + a22), (0.5 * (a11 - a22)).hypot(a12));
        Self {
            values: [
                form(&twist, &twist),
                form(&flip, &flip),
                mean + half_gap,
                mean - half_gap,
            ],
            vectors: [twist, flip, d1 * c + d2 * s, d2 * c - d1 * s],
        }
    }

    /// `a` with every eigenvalue below `floor` lifted to it.
    pub fn lifted(&self, a: &Matrix4<f64>, floor: f64) -> Matrix4<f64> {
        let mut lifted = *a;
        for (value, vector) in self.values.iter().zip(&self.vectors) {
            if *value < floor {
                lifted += vector * vector.transpose() * (floor - value);
            }
        }
        lifted
    }
}
