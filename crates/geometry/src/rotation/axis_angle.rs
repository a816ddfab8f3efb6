//! Axis and angle.

use super::error::finite;
use super::{Rotation, RotationError, RotationMatrix, RotationVector, exact, series};

/// A unit axis, and the angle about it in radians (2.22). (k, a) and (-k, -a) are the same rotation (2.23).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisAngle {
    axis: [f64; 3],
    angle: f64,
}

impl AxisAngle {
    /// From an axis of any length above zero, which is divided by its norm (1 ulp), and any finite angle in radians.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`], [`RotationError::Zero`].
    #[inline]
    pub fn new(axis: [f64; 3], angle: f64) -> Result<Self, RotationError> {
        finite("axis", &axis)?;
        finite("angle", &[angle])?;
        let axis = exact::unit(axis).ok_or(RotationError::Zero { what: "axis" })?;
        Ok(Self { axis, angle })
    }

    /// The unit axis.
    #[inline]
    pub const fn axis(self) -> [f64; 3] {
        self.axis
    }

    /// The angle, radians.
    #[inline]
    pub const fn angle(self) -> f64 {
        self.angle
    }

    /// The rotation vector, axis times angle (2.31). Error: 1 ulp.
    #[inline]
    pub fn vector(self) -> RotationVector {
        RotationVector::wrap(self.axis.map(|c| c * self.angle))
    }

    /// The quaternion (cos(a/2), sin(a/2) k) (2.43).
    ///
    /// Domain: all; no singular set. Error: 2 ulp, the vector part relative to its own norm.
    #[inline]
    pub fn rotation(self) -> Rotation {
        let half = self.angle / 2.0;
        let y = half * half;
        let (sin, cos) = if y > series::MOST {
            half.sin_cos()
        } else {
            let [cos, sinc] = series::cos_sinc(y);
            (sinc * half, cos)
        };
        // Half of a denormal angle may not be representable: then the sine is the angle's half to the last digit anyway.
        let [x, y, z] = self.axis.map(|c| sin * c);
        Rotation::wrap([cos, x, y, z])
    }

    /// The matrix (2.41), through the quaternion. Error: 4 ulp.
    #[inline]
    pub fn matrix(self) -> RotationMatrix {
        self.rotation().matrix()
    }
}

impl RotationVector {
    /// Axis and angle, the angle positive or zero (2.31).
    ///
    /// Singular set: the zero vector, for which the axis is x. Error: 1 ulp each. An angle beyond the largest number
    /// becomes that number.
    #[inline]
    pub fn axis_angle(self) -> AxisAngle {
        let axis = exact::unit(self.radians()).unwrap_or([1.0, 0.0, 0.0]);
        AxisAngle {
            axis,
            angle: self.angle().min(f64::MAX),
        }
    }
}

impl Rotation {
    /// Axis and angle, the angle 0 to pi.
    ///
    /// Singular set: the identity, for which the axis is x; half-turns, where k and -k are both right. Error: the axis
    /// 1 ulp, the angle 3 ulp of itself. Near the identity the axis is as exact as the quaternion's vector part.
    #[inline]
    pub fn axis_angle(self) -> AxisAngle {
        let [s, x, y, z] = self.quaternion();
        // The vector part of -q, so that the angle is pi at most.
        let sign = if s < 0.0 { -1.0 } else { 1.0 };
        let axis = exact::unit([x, y, z].map(|c| sign * c)).unwrap_or([1.0, 0.0, 0.0]);
        AxisAngle {
            axis,
            angle: self.angle(),
        }
    }
}

impl RotationMatrix {
    /// Axis and angle, through the quaternion; singular set and bound as [`Rotation::axis_angle`].
    pub fn axis_angle(self) -> AxisAngle {
        self.rotation().axis_angle()
    }
}
