//! Distance between rotations, and the shortest way from one to the other.

use super::{Rotation, RotationVector};

impl Rotation {
    /// The angle of the rotation from `self` to `other`, 0 to pi radians: the geodesic distance.
    ///
    /// Domain: all. Error: 4 ulp of 1, since the two quaternions are rounded; exactly 0 between equal numbers.
    #[inline]
    pub fn distance(self, other: Self) -> f64 {
        (self.inverse() * other).angle()
    }

    /// The rotation at fraction `t` of the shortest way from `self` to `other`, at constant speed (Shoemake 1985).
    ///
    /// self * exp(t log(self^-1 other)): no division by the sine of the angle between, which vanishes where the two are
    /// equal. `t` outside 0..1 extrapolates, and a `t` that is not finite returns `self`. Singular set: half-turns apart,
    /// where two ways are as short and either is taken. Error: 6 ulp within 0..1; exact at 0.
    #[inline]
    pub fn slerp(self, other: Self, t: f64) -> Self {
        let way = self.inverse() * other;
        let [_, x, y, z] = way.quaternion();
        if t == 0.0 || !t.is_finite() || [x, y, z] == [0.0; 3] {
            return self;
        }
        self * way.power(t)
    }

    /// exp(t log(self)), t finite.
    #[inline]
    fn power(self, t: f64) -> Self {
        let [s, x, y, z] = self.quaternion();
        let square = x * x + y * y + z * z;
        if square < 8.9e-16 {
            return self.power_of_tiny(t);
        }
        let n = square.sqrt();
        let (sin, cos) = (t * n.atan2(s.abs())).sin_cos();
        let scale = if s < 0.0 { -sin } else { sin } / n;
        Self::wrap([cos, scale * x, scale * y, scale * z])
    }

    /// The same for rotations so small that the squares of their vector part may underflow.
    #[cold]
    #[inline(never)]
    fn power_of_tiny(self, t: f64) -> Self {
        let way = self.vector().radians().map(|c| (t * c).clamp(-f64::MAX, f64::MAX));
        Self::from_vector(RotationVector::wrap(way))
    }
}
