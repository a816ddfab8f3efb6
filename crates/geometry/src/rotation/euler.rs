//! Euler angles, in all 24 conventions.

use super::error::finite;
use super::quaternion::product;
use super::{Rotation, RotationError, exact};

/// A coordinate axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// The first axis.
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

/// What the second and third turn are about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frames {
    /// About the axes of the fixed frame (extrinsic): the first turn is the rightmost factor.
    Static,
    /// About the axes that the earlier turns have moved (intrinsic): the first turn is the leftmost factor.
    Rotating,
}

/// One of the 24 conventions: three axes, neighbours different, and what they are attached to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Euler {
    axes: [Axis; 3],
    frames: Frames,
}

/// Three angles in radians, in the order in which the turns are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EulerAngles {
    /// The convention.
    pub convention: Euler,
    /// The angles of the first, second and third turn, radians.
    pub radians: [f64; 3],
}

impl Euler {
    /// The convention, or `None` where two neighbouring axes are the same.
    pub fn new(axes: [Axis; 3], frames: Frames) -> Option<Self> {
        (axes[0] != axes[1] && axes[1] != axes[2]).then_some(Self { axes, frames })
    }

    /// All 24.
    pub fn all() -> impl Iterator<Item = Self> {
        let xyz = [Axis::X, Axis::Y, Axis::Z];
        let triples = xyz
            .into_iter()
            .flat_map(move |a| xyz.into_iter().flat_map(move |b| xyz.map(|c| [a, b, c])));
        triples.flat_map(|axes| {
            [Frames::Static, Frames::Rotating]
                .into_iter()
                .filter_map(move |f| Self::new(axes, f))
        })
    }

    /// The axes in the order of the factors of the extrinsic form, i then j then k.
    fn static_axes(self) -> [usize; 3] {
        let [a, b, c] = self.axes.map(|axis| axis as usize);
        match self.frames {
            Frames::Static => [a, b, c],
            // Turns about moved axes a, b, c are turns about the fixed axes c, b, a.
            Frames::Rotating => [c, b, a],
        }
    }

    fn in_order(self, [first, second, third]: [f64; 3]) -> [f64; 3] {
        match self.frames {
            Frames::Static => [first, second, third],
            Frames::Rotating => [third, second, first],
        }
    }
}

impl EulerAngles {
    /// The rotation: the product of three turns.
    ///
    /// Domain: finite angles; no singular set. Error: 4 ulp.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`].
    pub fn rotation(self) -> Result<Rotation, RotationError> {
        finite("Euler angles", &self.radians)?;
        let axes = self.convention.static_axes();
        let angles = self.convention.in_order(self.radians);
        let turn = |n: usize| {
            let (sin, cos) = (angles[n] / 2.0).sin_cos();
            let mut q = [cos, 0.0, 0.0, 0.0];
            q[1 + axes[n]] = sin;
            q
        };
        // The first turn is the rightmost factor. Three unit quaternions make one to some ulp, so that it is never
        // zero.
        let q = product(turn(2), product(turn(1), turn(0)));
        Ok(Rotation::normalised(q).unwrap_or(Rotation::IDENTITY))
    }
}

/// The middle angle closer than this to its singular value: the angle between the outer turns is noise, 0 is taken.
const GIMBAL_LOCK_RAD: f64 = 2.0 * f64::EPSILON;

impl Rotation {
    /// The Euler angles in a convention: the first and third from -pi to pi, the second from 0 to pi where the outer axes
    /// are the same, from -pi/2 to pi/2 where they differ (after Bernardes and Viollet 2022).
    ///
    /// Singular set (lock): the second angle at an end of its range; only the sum or difference of the others is determined
    /// then, and the last is zero. At distance d from it each outer angle has condition 1/d, and errors to 4 ulp / d
    /// that cancel: the angles always give the rotation back to 8 ulp. Elsewhere: 4 ulp, relative to the angles' own norm
    /// where the three axes differ and the rotation is small.
    pub fn euler(self, convention: Euler) -> EulerAngles {
        let q = self.quaternion();
        let [i, j, k] = convention.static_axes();
        let free = match convention.frames {
            Frames::Static => -1.0,
            Frames::Rotating => 1.0,
        };
        let angles = if i == k {
            same_axes(q, i, j, free)
        } else {
            three_axes(q, [i, j, k], free)
        };
        EulerAngles {
            convention,
            radians: convention.in_order(angles).map(wrap),
        }
    }
}

/// +1 for an even permutation of the axes, -1 for an odd one.
fn parity(i: usize, j: usize) -> f64 {
    if (i + 1) % 3 == j { 1.0 } else { -1.0 }
}

/// The angles about i, j, i: half the sum and half the difference of the outer ones are the arguments of two complex
/// numbers.
fn same_axes(q: [f64; 4], i: usize, j: usize, free: f64) -> [f64; 3] {
    let k = 3 - i - j;
    let (a, b, c, d) = (q[0], q[1 + i], q[1 + j], q[1 + k] * parity(i, j));
    let (sum, difference) = halves([a, b], [c, d], free);
    [sum - difference, 2.0 * c.hypot(d).atan2(a.hypot(b)), sum + difference]
}

/// The angles about i, j, k.
fn three_axes(q: [f64; 4], [i, j, k]: [usize; 3], free: f64) -> [f64; 3] {
    let sign = parity(i, j);
    let (w, x, y, z) = (q[0], q[1 + i], q[1 + j], sign * q[1 + k]);
    let (a, b, c, d) = (w - y, x + z, y + w, z - x);
    // |w - y + i (x + z)| |y + w + i (z - x)| is the cosine of the second angle: by both sine and cosine it keeps its
    // digits near the lock.
    let cos = a.hypot(b) * c.hypot(d);
    let second = difference_of_products(w, y, z, x).atan2(cos);
    if cos > 0.5 {
        // Far from the lock: sine and cosine of each angle alone, which keeps small angles' digits.
        let first = (2.0 * (x * w + z * y)).atan2(difference_of_squares(w, y, z, x));
        let third = (2.0 * (z * w + x * y)).atan2(difference_of_squares(w, y, x, z));
        return [first, second, sign * third];
    }
    let (sum, difference) = halves([a, b], [c, d], free);
    [sum - difference, second, sign * (sum + difference)]
}

/// 2 (a b - c d)
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let (high, low) = exact::dot([a, -c], [b, d]);
    2.0 * (high + low)
}

/// a^2 - b^2 + c^2 - d^2
fn difference_of_squares(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let (high, low) = exact::dot([a, -b, c, -d], [a, b, c, d]);
    high + low
}

/// The arguments of two complex numbers, half the sum and half the difference of the outer angles. Where one of the two
/// numbers is zero to rounding its argument is free, and is taken so that the last turn is none: `free` is -1 where that
/// is the sum of the two, 1 where it is the difference.
fn halves([a, b]: [f64; 2], [c, d]: [f64; 2], free: f64) -> (f64, f64) {
    let (sum, difference) = (b.atan2(a), d.atan2(c));
    if c.hypot(d) < GIMBAL_LOCK_RAD {
        (sum, free * sum)
    } else if a.hypot(b) < GIMBAL_LOCK_RAD {
        (free * difference, difference)
    } else {
        (sum, difference)
    }
}

/// The angle brought back into -pi to pi by at most one turn.
fn wrap(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}
