//! Single precision, for renderers: computed in double precision and rounded once, so within 0.51 ulp.

use super::{Rotation, RotationError, RotationMatrix, RotationVector};

impl Rotation {
    /// From a quaternion (s, u1, u2, u3) of any length above zero. Error: 1 ulp of f64.
    ///
    /// # Errors
    /// As [`Rotation::from_quaternion`].
    pub fn from_quaternion_f32(q: [f32; 4]) -> Result<Self, RotationError> {
        Self::from_quaternion(q.map(f64::from))
    }

    /// The quaternion, each component rounded to the nearest f32.
    pub fn quaternion_f32(self) -> [f32; 4] {
        self.quaternion().map(|x| x as f32)
    }
}

impl RotationVector {
    /// From three components in radians. Exact.
    ///
    /// # Errors
    /// As [`RotationVector::new`].
    pub fn from_f32(radians: [f32; 3]) -> Result<Self, RotationError> {
        Self::new(radians.map(f64::from))
    }

    /// The components in radians, each rounded to the nearest f32; infinite beyond its largest number.
    pub fn to_f32(self) -> [f32; 3] {
        self.radians().map(|x| x as f32)
    }
}

impl RotationMatrix {
    /// From nine numbers by rows that are a rotation to within `tolerance`: at least 2e-7 for what f32 rounded.
    ///
    /// # Errors
    /// As [`RotationMatrix::new`].
    pub fn from_f32(rows: [[f32; 3]; 3], tolerance: f64) -> Result<Self, RotationError> {
        Self::new(rows.map(|row| row.map(f64::from)), tolerance)
    }

    /// The rows, each entry rounded to the nearest f32: orthonormal to 2 ulp of f32.
    pub fn to_f32(self) -> [[f32; 3]; 3] {
        self.rows().map(|row| row.map(|x| x as f32))
    }
}
