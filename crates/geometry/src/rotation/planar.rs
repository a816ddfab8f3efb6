//! Rotations of the plane.

use std::ops::Mul;

use super::error::finite;
use super::{RotationError, exact};

/// A rotation of the plane, held as a unit complex number (2.20), its modulus 1 to 2 ulp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation2([f64; 2]);

impl Rotation2 {
    /// The rotation that leaves everything in place.
    pub const IDENTITY: Self = Self([1.0, 0.0]);

    /// The rotation by an angle, radians: the exponential of the 1-vector (2.16, 2.18). Error: 1 ulp.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`].
    #[inline]
    pub fn from_angle(radians: f64) -> Result<Self, RotationError> {
        finite("angle", &[radians])?;
        Ok(Self::turn(radians))
    }

    #[inline]
    fn turn(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self([cos, sin])
    }

    /// From a complex number (real, imaginary) of any modulus above zero, which is divided by it. Error: 1 ulp.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`], [`RotationError::Zero`].
    #[inline]
    pub fn from_complex(z: [f64; 2]) -> Result<Self, RotationError> {
        finite("complex number", &z)?;
        exact::unit(z)
            .map(Self)
            .ok_or(RotationError::Zero { what: "complex number" })
    }

    /// The rotation nearest to a matrix by rows in the Frobenius norm, and the distance to it. Error: 2 ulp where the
    /// matrix is within 0.1 of a rotation.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`]; [`RotationError::Reflection`] where the determinant is
    /// negative, [`RotationError::Singular`] where it is zero.
    #[inline]
    pub fn nearest(rows: [[f64; 2]; 2]) -> Result<(Self, f64), RotationError> {
        let [[a, b], [c, d]] = rows;
        let numbers = [a, b, c, d];
        finite("matrix", &numbers)?;
        // To length 1 first, so that neither the sums nor the determinant overflow.
        let [p, q, r, s] = exact::unit(numbers).ok_or(RotationError::Singular { determinant: 0.0 })?;
        // p s - q r with both products' errors: for a nearly singular matrix it is all cancellation.
        let (high, low) = exact::dot([p, -q], [s, r]);
        let determinant = high + low;
        if determinant.abs() <= f64::EPSILON {
            return Err(RotationError::Singular { determinant });
        } else if determinant < 0.0 {
            return Err(RotationError::Reflection { determinant });
        }
        // tr(R^T M) = cos (a + d) + sin (c - b) is largest where (cos, sin) is along these sums.
        let near = Self::from_complex([p + s, r - q])?;
        let [[e, f], [g, h]] = near.matrix();
        Ok((near, exact::length([a - e, b - f, c - g, d - h])))
    }

    /// The angle, -pi to pi radians: the logarithm. Singular set: the half-turn, either sign. Error: 1 ulp of itself.
    #[inline]
    pub fn angle(self) -> f64 {
        self.0[1].atan2(self.0[0])
    }

    /// The complex number (real, imaginary).
    #[inline]
    pub const fn complex(self) -> [f64; 2] {
        self.0
    }

    /// The matrix by rows (2.16). Exact: orthonormal to 2 ulp as the complex number is unit to 2 ulp.
    #[inline]
    pub fn matrix(self) -> [[f64; 2]; 2] {
        let [c, s] = self.0;
        [[c, -s], [s, c]]
    }

    /// The inverse: the conjugate (2.21). Exact.
    #[inline]
    pub fn inverse(self) -> Self {
        Self([self.0[0], -self.0[1]])
    }

    /// The image of a vector, in the vector's unit; error below 2 ulp of its norm (2.20).
    #[inline]
    pub fn apply(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [c, s] = self.0;
        [c * x - s * y, s * x + c * y]
    }

    /// The angle between two rotations, 0 to pi radians. Error: 3 ulp of 1; exactly 0 between equal numbers.
    #[inline]
    pub fn distance(self, other: Self) -> f64 {
        (self.inverse() * other).angle().abs()
    }

    /// The rotation at fraction `t` of the shorter way to `other`; `self` for a `t` that is not finite. Singular set:
    /// half-turns apart. Error: 4 ulp within 0..1.
    #[inline]
    pub fn slerp(self, other: Self, t: f64) -> Self {
        let way = t * (self.inverse() * other).angle();
        if way.is_finite() { self * Self::turn(way) } else { self }
    }
}

/// The composition (2.21). Error: 3 ulp; the modulus is put back to 1.
impl Mul for Rotation2 {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let ([a, b], [c, d]) = (self.0, other.0);
        let (x, y) = (a * c - b * d, a * d + b * c);
        // One step of Newton for 1 / sqrt, as of the quaternions.
        let repair = 1.5 - 0.5 * (x * x + y * y);
        Self([x * repair, y * repair])
    }
}
