//! From one start to the minimum below it: pose, depth scale and offset of the surface.
//!
//! With `q` a point, `b` its beam, `z` its depth, `(R, t)` the pose, `k` the depth scale and `o` the offset of the surface:
//!
//! ```text
//! p = R (q - b z k) + t,     s = (d(p) - o) / sqrt(n' R C R' n + s_bone^2),     n = grad d(p)                    (1)
//! ```
//!
//! Minimised is the sum of a kernel of `s^2`, and the squares of what is known before: of `k`, of `o`, and of landmarks. The deviation
//! below is held while a step is made: were it a function of the pose, points would be drawn to where the surface shows them their
//! widest side.

mod beyond;
mod equations;
mod exact;
mod problem;
mod schedule;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};

pub(crate) use beyond::{MOST_BEYOND, NEUTRAL_BEYOND, Say, beyond_cost};
pub(crate) use exact::Exact;
pub(crate) use problem::{Distances, Problem};
pub(crate) use schedule::{Ended, Noise, Solver, Stage};

/// Unknowns: turn and shift of the cloud's centre, depth scale, offset.
pub(crate) const UNKNOWNS: usize = 8;
pub(crate) type Matrix8 = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
pub(crate) type Vector8 = SVector<f64, UNKNOWNS>;

/// Where the fit is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct State {
    /// Rotation, from the tracker's axes to the bone's.
    pub(crate) turn: Matrix3<f64>,
    /// The image of the cloud's centre, mm.
    pub(crate) shift: Vector3<f64>,
    /// Depth scale `k`: depths are too long by this share.
    pub(crate) scale: f64,
    /// Offset `o`, mm: the true bone lies so far outside of the surface.
    pub(crate) offset: f64,
}

/// What is known before of the two numbers beside the pose, and of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Priors {
    /// Deviation of the depth scale about 0: of the speed of sound, as a share. 0 holds it at 0.
    pub depth_scale: f64,
    /// Deviation of the offset of the surface about 0, mm. 0 holds it at 0.
    pub offset_mm: f64,
    /// Deviation of the surface itself from place to place, mm: added to that of each point.
    pub bone_mm: f64,
    /// Deviation of what lies between tip and bone on one side of it and not on the other, soft tissue for instance, mm: nothing is fitted for
    /// it, and what it does to the pose is in its covariance.
    pub side_mm: f64,
}

impl Default for Priors {
    fn default() -> Self {
        Self {
            depth_scale: 0.03,
            offset_mm: 1.0,
            bone_mm: 0.15,
            side_mm: 0.0,
        }
    }
}

/// One landmark about the cloud's centre, its place in the bone's frame, and its deviation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Anchor {
    pub(crate) from: Vector3<f64>,
    pub(crate) to: Vector3<f64>,
    pub(crate) sigma_mm: f64,
}

impl State {
    /// After a small motion in place and changes of the two numbers.
    pub(crate) fn moved(&self, step: &Vector8) -> Option<Self> {
        if step.iter().any(|x| !x.is_finite()) {
            return None;
        }
        Some(Self {
            turn: turned(&step.fixed_rows::<3>(0).into_owned()) * self.turn,
            shift: self.shift + step.fixed_rows::<3>(3),
            scale: self.scale + step[6],
            offset: self.offset + step[7],
        })
    }
}

/// exp of a rotation vector, rad (Rodrigues).
pub(crate) fn turned(w: &Vector3<f64>) -> Matrix3<f64> {
    let angle = w.norm();
    let cross = w.cross_matrix();
    // The two series to rounding below the limit.
    let (a, b) = if angle < 1e-4 {
        (1.0 - angle * angle / 6.0, 0.5 - angle * angle / 24.0)
    } else {
        (angle.sin() / angle, (1.0 - angle.cos()) / (angle * angle))
    };
    Matrix3::identity() + cross * a + cross * cross * b
}

/// How far apart two poses lie, mm: root mean square over a ball of the points' radius.
pub(crate) fn apart_mm(a: &State, b: &State, radius_mm: f64) -> f64 {
    let turn = (a.turn - b.turn).norm_squared() * radius_mm * radius_mm / 3.0;
    (turn + (a.shift - b.shift).norm_squared()).sqrt()
}

/// The motion from `b` to `a`: rotation vector, and shift of the points' centre.
pub(crate) fn motion(a: &State, b: &State) -> Vector6<f64> {
    let turn = a.turn * b.turn.transpose();
    // The vector of a rotation up to its angle over its sine: a distance of 90 degrees and more is no small error of anything.
    let skew = Vector3::new(
        turn[(2, 1)] - turn[(1, 2)],
        turn[(0, 2)] - turn[(2, 0)],
        turn[(1, 0)] - turn[(0, 1)],
    ) * 0.5;
    let scale = if turn.trace() > 1.0 {
        1.0
    } else {
        std::f64::consts::PI / skew.norm().max(1e-3)
    };
    let (w, v) = (skew * scale, a.shift - b.shift);
    Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z)
}
