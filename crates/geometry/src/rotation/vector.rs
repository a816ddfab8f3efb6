//! The rotation vector: exponential and logarithm.

use super::error::finite;
use super::{Rotation, RotationError, exact, series};

/// A rotation vector: axis times angle, radians (2.24). Any finite vector; [`Rotation::vector`] returns norms up to pi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotationVector([f64; 3]);

/// Below this angle sin(a) = a and cos(a) = 1 to within a quarter of an ulp: a^2 / 6 < 2^-56, a^2 / 2 < 2^-54.
const TINY_RAD: f64 = 7.450_580_596_923_828e-9; // 2^-27

impl RotationVector {
    /// No rotation.
    pub const ZERO: Self = Self([0.0; 3]);

    /// From three components in radians.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`].
    pub fn new(radians: [f64; 3]) -> Result<Self, RotationError> {
        finite("rotation vector", &radians)?;
        Ok(Self(radians))
    }

    /// From a skew matrix by rows (2.25), of which the mean of the two triangles is taken. Error: 1 ulp.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`].
    pub fn from_skew(rows: [[f64; 3]; 3]) -> Result<Self, RotationError> {
        finite("skew matrix", rows.as_flattened())?;
        let [[_, a, b], [c, _, d], [e, f, _]] = rows;
        // Halved after the subtraction unless that overflows: a denormal halved first would lose a bit.
        let half = |x: f64, y: f64| {
            if (x - y).is_finite() {
                (x - y) / 2.0
            } else {
                x / 2.0 - y / 2.0
            }
        };
        Ok(Self([half(f, d), half(b, e), half(c, a)]))
    }

    /// Wraps components that the caller knows to be finite.
    pub(crate) const fn wrap(radians: [f64; 3]) -> Self {
        Self(radians)
    }

    /// The components, radians.
    pub const fn radians(self) -> [f64; 3] {
        self.0
    }

    /// The angle: the vector's norm, radians, to 1 ulp; infinite where the norm is beyond the largest number.
    #[inline]
    pub fn angle(self) -> f64 {
        exact::length(self.0)
    }

    /// The skew matrix by rows (2.25). Exact.
    pub fn skew(self) -> [[f64; 3]; 3] {
        let [x, y, z] = self.0;
        [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    }
}

impl Rotation {
    /// The exponential of a rotation vector (2.43); thesis section 2.5.6.
    ///
    /// Domain: any finite vector; no singular set. Error: 2 ulp, and the vector part 3 ulp of its own norm, down to
    /// denormals; beyond 2^50 rad the angle's own rounding adds 2^-103 times the angle.
    #[inline]
    pub fn from_vector(vector: RotationVector) -> Self {
        Self::wrap(exp_double(vector.0))
    }

    /// The logarithm, of norm 0 to pi; thesis section 2.5.3 with the errata's signs.
    ///
    /// Domain: every rotation. Singular set: half-turns, where w and -w are both right and either is returned. Error:
    /// 3 ulp, relative to the vector's own norm down to denormals.
    #[inline]
    pub fn vector(self) -> RotationVector {
        let [s, x, y, z] = self.quaternion();
        // -q is the same rotation: with s < 0 the angle is that of -q, and the vector's sign with it.
        let scale = (2.0 * series::arc(s.abs(), x * x + y * y + z * z)).copysign(s);
        RotationVector::wrap([scale * x, scale * y, scale * z])
    }

    /// The angle, 0 to pi radians, to 3 ulp of itself also near 0.
    #[inline]
    pub fn angle(self) -> f64 {
        angle(self.quaternion())
    }
}

/// The angle of the rotation whose quaternion is unit to a few ulp.
#[inline]
pub(crate) fn angle([s, x, y, z]: [f64; 4]) -> f64 {
    let square = x * x + y * y + z * z;
    // Below that the squares lose digits to underflow.
    let n = if square > 1e-200 {
        square.sqrt()
    } else {
        exact::length([x, y, z])
    };
    // Rounding of n and arc together may pass pi by an ulp.
    (2.0 * n * series::arc(s.abs(), square)).min(std::f64::consts::PI)
}

/// exp(w / 2) as a quaternion: (cos(h), sin(h) w / abs(w)) with h = abs(w) / 2.
#[inline]
pub(crate) fn exp_double(w: [f64; 3]) -> [f64; 4] {
    let y = 0.25 * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    // Numbers out of each branch, which stay in registers; an array would go through memory. Squares that underflow make
    // no difference: then the series are 1 to the last digit.
    let (cos, scale, unit) = if y > series::MOST {
        let unit = if exact::largest(w) > exact::BIG {
            exact::TINY_UNIT
        } else {
            1.0
        };
        let (cos, scale) = far(w, unit);
        (cos, scale, unit)
    } else {
        let [cos, sinc] = series::cos_sinc(y);
        (cos, 0.5 * sinc, 1.0)
    };
    [cos, scale * (unit * w[0]), scale * (unit * w[1]), scale * (unit * w[2])]
}

/// The cosine of the half angle, and its sine divided by `unit` times the angle, for vectors longer than pi; `unit`, a power
/// of two, keeps squares from overflowing.
///
/// The norm carries its own rounding error along: else the angle would be wrong by an ulp of itself, which is many ulp of
/// the result when the vector is long.
#[cold]
#[inline(never)]
fn far(w: [f64; 3], unit: f64) -> (f64, f64) {
    let (n, rest) = exact::norm(w.map(|c| unit * c));
    // Through the quarter angle where the half may be beyond the largest number; of that angle no digit is left anyway.
    let (sin, cos) = if unit == 1.0 {
        sin_cos_sum(n / 2.0, rest / 2.0)
    } else {
        let (sin, cos) = (n / 4.0 / unit).sin_cos();
        (2.0 * sin * cos, (cos - sin) * (cos + sin))
    };
    // First order in the norm's rest: sin / (n + rest) = (sin / n) (1 - rest / n).
    let scale = sin / n;
    (cos, scale - scale * (rest / n))
}

/// Sine and cosine of a + b, b a rounding error of a.
fn sin_cos_sum(a: f64, b: f64) -> (f64, f64) {
    let (sin, cos) = a.sin_cos();
    let (db, cb) = if b.abs() < TINY_RAD { (b, 1.0) } else { b.sin_cos() };
    (sin * cb + cos * db, cos * cb - sin * db)
}

/// log(q) for a quaternion that is unit to a few ulp: u / abs(u) times the angle from 0 to pi between q and 1.
pub(crate) fn log_half(q: [f64; 4]) -> [f64; 3] {
    let [s, x, y, z] = q;
    let scale = series::arc(s.abs(), x * x + y * y + z * z);
    if s >= 0.0 {
        return [scale * x, scale * y, scale * z];
    }
    // The supplement of the angle to -1. q = -1 has no axis: the first is taken.
    let n = exact::length([x, y, z]);
    let angle = std::f64::consts::PI - scale * n;
    exact::unit([x, y, z]).unwrap_or([1.0, 0.0, 0.0]).map(|c| c * angle)
}
