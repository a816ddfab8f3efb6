//! Rotation matrices of space.

use std::ops::Mul;

use nalgebra::Matrix3;

use super::{Rotation, RotationVector, exact};

/// A rotation matrix by rows (2.15): orthonormal and of determinant +1, both to 2 ulp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotationMatrix([[f64; 3]; 3]);

impl From<RotationMatrix> for Matrix3<f64> {
    fn from(matrix: RotationMatrix) -> Self {
        Self::from_fn(|i, j| matrix.0[i][j])
    }
}

impl RotationMatrix {
    /// Wraps rows that the caller knows to be a rotation to 2 ulp.
    pub(crate) const fn wrap(rows: [[f64; 3]; 3]) -> Self {
        Self(rows)
    }

    /// The rows.
    pub const fn rows(self) -> [[f64; 3]; 3] {
        self.0
    }

    /// The inverse: the transpose (2.2). Exact.
    pub fn inverse(self) -> Self {
        let m = self.0;
        Self([0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i])))
    }

    /// The image of a vector, in the vector's unit; error below 3 ulp of its norm.
    #[inline]
    pub fn apply(self, v: [f64; 3]) -> [f64; 3] {
        self.0.map(|[a, b, c]| a * v[0] + b * v[1] + c * v[2])
    }

    /// The quaternion, its largest component positive (2.36, 2.37).
    ///
    /// Domain: every rotation; no singular set. Error: 3 ulp against the rotation nearest to the numbers, and the vector
    /// part relative to its own norm near the identity, down to denormals.
    #[inline]
    pub fn rotation(self) -> Rotation {
        quaternion(self.0)
    }

    /// The logarithm through the quaternion (2.36, 2.37, then section 2.5.3): the direct formulas 2.32 to 2.35 lose half
    /// the digits near 0 and pi.
    ///
    /// Singular set: half-turns, where w and -w are both right. Error: 4 ulp of its own norm.
    #[inline]
    pub fn vector(self) -> RotationVector {
        self.rotation().vector()
    }
}

impl Rotation {
    /// The matrix (2.38).
    ///
    /// Domain: every rotation; no singular set. Error: 1 ulp of each entry. The products carry their rounding errors, and
    /// what the quaternion's norm lacks to 1 is divided out: so the matrix is orthonormal to 2 ulp.
    #[inline]
    pub fn matrix(self) -> RotationMatrix {
        let [s, x, y, z] = self.quaternion();
        RotationMatrix::wrap(rows(s, x, y, z))
    }
}

/// The matrix of a quaternion whose norm is 1 to a few ulp, by rows.
///
/// Never inlined, and by four numbers, which come in registers: next to what computes the quaternion, compilers pair up
/// operations across the two so badly that the whole takes twice as long.
#[inline(never)]
fn rows(s: f64, x: f64, y: f64, z: f64) -> [[f64; 3]; 3] {
    let q = [s, x, y, z];
    let high = q.map(exact::coarse);
    let low = each(|i| q[i] - high[i]);
    // a^2 as high^2, exact, and low (high + a).
    let squares = high.map(|x| x * x);
    let sums = each(|i| high[i] + q[i]);
    let rest = each(|i| low[i] * sums[i]);
    // |q|^2 - 1: the high squares are exact multiples of 2^-52, so that nothing cancels but what is exact.
    let off = exact::sum([squares[0] - 1.0, squares[1], squares[2], squares[3]]) + exact::sum(rest);
    // The quaternion over its norm: only what the multiples of 2^-26 leave is changed.
    let low = each(|i| low[i] - q[i] * (0.5 * off));
    let rest = each(|i| low[i] * sums[i]);
    // Doubling is exact: the factor 2 of (2.38) costs no rounding.
    let (twice_high, twice_low) = (high.map(|x| x + x), low.map(|x| x + x));
    let double = |a: usize, b: usize| (twice_high[a] * high[b], twice_high[a] * low[b] + twice_low[a] * q[b]);
    let diagonal = |a: usize, b: usize| (1.0 - 2.0 * (squares[a] + squares[b])) - 2.0 * (rest[a] + rest[b]);
    let [s, x, y, z] = [0, 1, 2, 3];
    let (xy, xz, yz) = (double(x, y), double(x, z), double(y, z));
    let (sx, sy, sz) = (double(s, x), double(s, y), double(s, z));
    [
        [diagonal(y, z), minus(xy, sz), plus(xz, sy)],
        [plus(xy, sz), diagonal(x, z), minus(yz, sx)],
        [minus(xz, sy), plus(yz, sx), diagonal(x, y)],
    ]
}

#[inline]
fn each(f: impl Fn(usize) -> f64) -> [f64; 4] {
    [f(0), f(1), f(2), f(3)]
}

/// The sum of two numbers with their rests, rounded once: the high parts are multiples of 2^-51 below 2.
#[inline]
fn plus(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 + b.0) + (a.1 + b.1)
}

/// The difference, likewise.
#[inline]
fn minus(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0) + (a.1 - b.1)
}

impl RotationVector {
    /// The matrix exp of the skew matrix (2.39), through the quaternion: 2.41 costs as much and loses orthonormality.
    ///
    /// Domain: any finite vector; no singular set. Error: 4 ulp; the skew part relative to its own norm.
    #[inline]
    pub fn matrix(self) -> RotationMatrix {
        Rotation::from_vector(self).matrix()
    }
}

/// The quaternion of a matrix that is orthonormal to rounding: the column of 4 q qT with the largest diagonal, divided by
/// its norm.
///
/// The squares 2.36 are its diagonal, the products 2.37 the rest. Dividing by the column's norm, not by twice the root of
/// its largest entry, keeps the quaternion unit where the matrix is off by rounding.
#[inline]
pub(crate) fn quaternion([[a, b, c], [d, e, f], [g, h, i]]: [[f64; 3]; 3]) -> Rotation {
    // At least one of the four is 1 or more; which one only has to be nearly the largest, so the trace decides often.
    let column = if a + e + i > 0.0 {
        [1.0 + a + e + i, h - f, c - g, d - b]
    } else if a >= e && a >= i {
        [h - f, 1.0 + a - e - i, d + b, c + g]
    } else if e >= i {
        [c - g, d + b, 1.0 - a + e - i, h + f]
    } else {
        [d - b, c + g, h + f, 1.0 - a - e + i]
    };
    Rotation::nearly(column)
}

/// The composition: turns by `other` first. Through the quaternions, so that products of many stay rotations.
///
/// Error: 6 ulp.
impl Mul for RotationMatrix {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        (self.rotation() * other.rotation()).matrix()
    }
}
