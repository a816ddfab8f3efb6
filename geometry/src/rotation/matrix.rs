//! Rotation matrices of space.

use std::ops::Mul;

use super::{AxisAngle, Nearest, Rotation, RotationError, RotationVector, exact};

/// A rotation matrix by rows (2.15): orthonormal and of determinant +1, both to 2 ulp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotationMatrix([[f64; 3]; 3]);

impl RotationMatrix {
    /// From nine numbers by rows that are a rotation to within `tolerance`; what is off is repaired by
    /// [`RotationMatrix::nearest`], and a matrix that is orthonormal to 2 ulp keeps its bits.
    ///
    /// `tolerance` bounds the Frobenius distance to the nearest rotation. Trackers' files need about 1e-3.
    ///
    /// # Errors
    /// Those of [`RotationMatrix::nearest`], and [`RotationError::NotOrthonormal`].
    pub fn new(rows: [[f64; 3]; 3], tolerance: f64) -> Result<Self, RotationError> {
        let Nearest { matrix, distance } = Self::nearest(rows)?;
        if distance <= tolerance {
            return Ok(matrix);
        }
        Err(RotationError::NotOrthonormal { distance, tolerance })
    }

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

    /// Axis and angle, through the quaternion; singular set and bound as [`Rotation::axis_angle`].
    pub fn axis_angle(self) -> AxisAngle {
        self.rotation().axis_angle()
    }
}

impl Rotation {
    /// The matrix (2.38).
    ///
    /// Domain: every rotation; no singular set. Error: 1 ulp of each entry. The products carry their rounding errors, and
    /// what the quaternion's norm lacks to 1 is divided out: so the matrix is orthonormal to 2 ulp.
    #[inline]
    pub fn matrix(self) -> RotationMatrix {
        let [s, x, y, z] = self.quaternion().map(exact::fixed);
        let off = self.excess();
        let minus_s = (-s.0, -s.1);
        let sum = |a, b, c, d| twice(a, b, c, d, off, 0.0);
        let diagonal = |a: (f64, f64), b: (f64, f64)| twice((-a.0, -a.1), a, (-b.0, -b.1), b, off, 1.0);
        RotationMatrix::wrap([
            [diagonal(y, z), sum(x, y, minus_s, z), sum(x, z, s, y)],
            [sum(x, y, s, z), diagonal(x, z), sum(y, z, minus_s, x)],
            [sum(x, z, minus_s, y), sum(y, z, s, x), diagonal(x, y)],
        ])
    }
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

/// one + 2 (a b + c d) / (1 + off), rounded once: the high products and their sum are exact.
#[inline]
fn twice(a: (f64, f64), b: (f64, f64), c: (f64, f64), d: (f64, f64), off: f64, one: f64) -> f64 {
    let (p, q) = (exact::fixed_product(a, b), exact::fixed_product(c, d));
    let high = p.0 + q.0;
    let low = p.1 + q.1;
    (one + 2.0 * high) + 2.0 * (low - (high + low) * off)
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
