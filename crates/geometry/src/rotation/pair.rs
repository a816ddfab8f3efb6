//! The logarithm of a rotation of 4-space: six numbers, or a pair of vectors.

use super::error::finite;
use super::vector::{exp_double, log_half};
use super::{Rotation, Rotation4, RotationError, exact};

/// The six numbers (a, b, c, d, e, f) of a skew 4 x 4 matrix (2.45), radians.
///
/// Also a sum Hg(g) + Hd(h) of two that commute (2.52, 2.53), which is how exponential and logarithm are computed: that
/// holds all digits for every discriminant, where 2.70 loses half of them near 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Log4([f64; 6]);

impl Log4 {
    /// From (a, b, c, d, e, f), radians.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`].
    pub fn new(radians: [f64; 6]) -> Result<Self, RotationError> {
        finite("4-D rotation logarithm", &radians)?;
        Ok(Self(radians))
    }

    /// From the two factors g and h. Error: 1 ulp.
    pub(crate) fn from_factors(g: [f64; 3], h: [f64; 3]) -> Self {
        Self([
            h[0] - g[0],
            h[1] - g[1],
            h[2] - g[2],
            -g[2] - h[2],
            g[1] + h[1],
            -g[0] - h[0],
        ])
    }

    /// The six numbers (a, b, c, d, e, f), radians.
    pub const fn radians(self) -> [f64; 6] {
        self.0
    }

    /// The skew matrix by rows (2.45). Exact.
    pub fn skew(self) -> [[f64; 4]; 4] {
        let [a, b, c, d, e, f] = self.0;
        [[0.0, a, b, c], [-a, 0.0, d, e], [-b, -d, 0.0, f], [-c, -e, -f, 0.0]]
    }

    /// Twice the vectors g and h: -(a+f, b-e, c+d) and (a-f, b+e, c-d). Error: half an ulp of each component.
    pub(crate) fn twice_factors(self) -> ([f64; 3], [f64; 3]) {
        let [a, b, c, d, e, f] = self.0;
        ([-(a + f), e - b, -(c + d)], [a - f, b + e, c - d])
    }

    /// The vectors g and h with H = Hg(g) + Hd(h), radians. Error: 1 ulp of each component.
    pub fn factors(self) -> ([f64; 3], [f64; 3]) {
        let (g, h) = self.twice_factors();
        (g.map(|x| x / 2.0), h.map(|x| x / 2.0))
    }

    /// The two angles, first >= second >= 0, radians: abs(g) + abs(h) and the difference (2.69). Error: 2 ulp of the first.
    pub fn angles(self) -> [f64; 2] {
        let (g, h) = self.twice_factors();
        let (g, h) = (exact::length(g), exact::length(h));
        [g / 2.0 + h / 2.0, (g / 2.0 - h / 2.0).abs()]
    }

    /// The exponential (2.65): exp H = Qg(exp g) Qd(exp h).
    ///
    /// Domain: numbers up to half the largest; no singular set. Error: 3 ulp of 1 at every discriminant, and as many more as
    /// the first angle ([`Self::angles`]) has radians, since the factors are rounded before they are taken round the circle: of
    /// 1e4 rad some thousands, beyond 1e15 rad every digit. Up to a first angle of pi / 2 the skew part has 3 ulp of its own norm;
    /// beyond, it goes through 0 at every half-turn and has the error above.
    pub fn exp(self) -> Rotation4 {
        let (g, h) = self.twice_factors();
        Rotation4::from_pair(Rotation::wrap(exp_double(g)), Rotation::wrap(exp_double(h)))
    }
}

impl Rotation4 {
    /// The logarithm of least angles: abs(g) + abs(h) <= pi.
    ///
    /// Singular set: the larger angle pi, where two are as small and either is returned; there and at isoclinic half-turns
    /// an axis is free. Error: 4 ulp, relative to its own norm near the identity.
    pub fn log(self) -> Log4 {
        let [(p, a), (q, b)] = <[Rotation; 2]>::from(self.pair()).map(|r| (r.quaternion(), half_angle(r.quaternion())));
        // (p, q) and (-p, -q) are the same rotation; the other pair has the angles pi - a and pi - b.
        let sign = if a + b > std::f64::consts::PI { -1.0 } else { 1.0 };
        let [g, h] = [p, q].map(|x| log_half(x.map(|c| sign * c)));
        Log4::from_factors(g, h)
    }
}

/// The angle between the quaternion and 1, 0 to pi.
fn half_angle([s, x, y, z]: [f64; 4]) -> f64 {
    exact::length([x, y, z]).atan2(s)
}
