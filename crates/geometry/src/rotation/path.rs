//! Distance between rotations, and the shortest way from one to the other.

use super::quaternion::product;
use super::vector::{angle, exp_double};
use super::{Rotation, series};

impl Rotation {
    /// The angle of the rotation from `self` to `other`, 0 to pi radians: the geodesic distance.
    ///
    /// Domain: all. Error: 4 ulp of 1, since the two quaternions are rounded; exactly 0 between equal numbers.
    #[inline]
    pub fn distance(self, other: Self) -> f64 {
        angle(product(self.inverse().quaternion(), other.quaternion()))
    }

    /// The rotation at fraction `t` of the shortest way from `self` to `other`, at constant speed (Shoemake 1985).
    ///
    /// self * exp(t log(self^-1 other)): no division by the sine of the angle between, which vanishes where the two are
    /// equal. `t` outside 0..1 extrapolates, and a `t` that is not finite returns `self`. Singular set: half-turns apart,
    /// where two ways are as short and either is taken. Error: 6 ulp within 0..1; exact at 0.
    #[inline]
    pub fn slerp(self, other: Self, t: f64) -> Self {
        let [s, x, y, z] = product(self.inverse().quaternion(), other.quaternion());
        let u = [x, y, z];
        if t == 0.0 || !t.is_finite() || u == [0.0; 3] {
            return self;
        }
        // The sign of s chooses the shorter way: q and -q are the same rotation.
        let log = (2.0 * series::arc(s.abs(), x * x + y * y + z * z)).copysign(s);
        let scale = t * log;
        // A huge t must not make an infinite vector, of which no exponential is had.
        let way = u.map(|c| (scale * c).clamp(-f64::MAX, f64::MAX));
        self * Self::wrap(exp_double(way))
    }
}
