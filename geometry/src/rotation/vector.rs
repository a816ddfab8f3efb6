//! The rotation vector: exponential and logarithm.

use super::error::finite;
use super::{Rotation, RotationError, exact};

/// A rotation vector: axis times angle, radians (2.24). Any finite vector; [`Rotation::vector`] returns norms up to pi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotationVector([f64; 3]);

/// Below this angle sin(a) = a and cos(a) = 1 to within a quarter of an ulp: a^2 / 6 < 2^-56, a^2 / 2 < 2^-54.
const TINY: f64 = 7.450_580_596_923_828e-9; // 2^-27

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
    /// Domain: any finite vector; no singular set. Error: 2 ulp, and the vector part relative to its own norm, down to
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
        let sign = if s < 0.0 { -2.0 } else { 2.0 };
        RotationVector::wrap(log_half([s.abs(), x, y, z]).map(|c| sign * c))
    }

    /// The angle, 0 to pi radians, to 2 ulp of itself also near 0.
    #[inline]
    pub fn angle(self) -> f64 {
        let [s, x, y, z] = self.quaternion();
        let square = x * x + y * y + z * z;
        let n = if square > 1e-200 {
            square.sqrt()
        } else {
            exact::length([x, y, z])
        };
        2.0 * n.atan2(s.abs())
    }
}

/// exp(w / 2) as a quaternion: (cos(h), sin(h) w / abs(w)) with h = abs(w) / 2.
#[inline]
pub(crate) fn exp_double(w: [f64; 3]) -> [f64; 4] {
    let square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    // 2^-50 to 4^2: neither tiny nor so long that the norm's rounding counts.
    let (cos, scale) = if square > 8.9e-16 && square < 16.0 {
        let n = square.sqrt();
        let (sin, cos) = (n / 2.0).sin_cos();
        (cos, sin / n)
    } else if exact::largest(w) > exact::BIG {
        return exp_unbounded(w);
    } else {
        far(w)
    };
    [cos, scale * w[0], scale * w[1], scale * w[2]]
}

/// The cosine of the half angle, and its sine divided by the angle, for tiny and for long vectors.
///
/// The norm carries its own rounding error along: else the angle would be wrong by an ulp of itself, which is many ulp of
/// the result when the vector is long.
fn far(w: [f64; 3]) -> (f64, f64) {
    if exact::largest(w) < TINY {
        return (1.0, 0.5);
    }
    let (n, rest) = exact::norm(w);
    let (sin, cos) = sin_cos_sum(n / 2.0, rest / 2.0);
    let scale = sin / n;
    (cos, scale - scale * (rest / n))
}

/// exp(w / 2) where squares overflow: a rotation about the right axis; of the angle no digit is left.
fn exp_unbounded(w: [f64; 3]) -> [f64; 4] {
    let [x, y, z] = exact::unit(w).unwrap_or([1.0, 0.0, 0.0]);
    let (sin, cos) = exact::length(w.map(|c| c / 4.0)).sin_cos();
    // Of the quarter angle: twice through the product, since the half may be beyond the largest number.
    let (sin, cos) = (2.0 * sin * cos, (cos - sin) * (cos + sin));
    [cos, sin * x, sin * y, sin * z]
}

/// Sine and cosine of a + b, b a rounding error of a.
fn sin_cos_sum(a: f64, b: f64) -> (f64, f64) {
    let (sin, cos) = a.sin_cos();
    let (db, cb) = if b.abs() < TINY { (b, 1.0) } else { b.sin_cos() };
    (sin * cb + cos * db, cos * cb - sin * db)
}

/// log(q) for a quaternion that is unit to a few ulp: u / abs(u) times the angle from 0 to pi between q and 1.
#[inline]
pub(crate) fn log_half(q: [f64; 4]) -> [f64; 3] {
    let [s, x, y, z] = q;
    let square = x * x + y * y + z * z;
    // 2^-50: no square of a component that counts underflows.
    if square < 8.9e-16 {
        return log_half_tiny(s, [x, y, z]);
    }
    let n = square.sqrt();
    let scale = n.atan2(s) / n;
    [scale * x, scale * y, scale * z]
}

/// The same where abs(u) < 2^-25. q = -1 has no axis: the first is taken.
#[cold]
#[inline(never)]
fn log_half_tiny(s: f64, u: [f64; 3]) -> [f64; 3] {
    if s > 0.0 {
        // atan(t) = t - t^3 / 3, the next term below 2^-100 of t.
        let t = exact::length(u);
        return u.map(|c| c / s * (1.0 - t * t / 3.0));
    }
    let angle = std::f64::consts::PI - exact::length(u);
    exact::unit(u).unwrap_or([1.0, 0.0, 0.0]).map(|c| c * angle)
}
