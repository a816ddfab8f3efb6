//! The steady turn and slide from one pose to another.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

/// Below this angle series are used: their next term is below rounding (`angle^4 / 120` and less).
const SMALL_ANGLE: f64 = 1e-4;

/// A twist, steady in the world: at time `t` the pose is `from` turned by `t turn` and carried along, 0 to 1.
///
/// With `V(w) = 1 + (1 - cos a)/a^2 [w] + (a - sin a)/a^3 [w]^2`, `a = |w|`, the origin of the tube's frame is at
/// `o + t V(t turn) slide` (Murray, Li and Sastry 1994, equation 2.36, about `o`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Screw {
    from: Isometry3<f64>,
    /// Rotation vector of the whole turn, at most half a turn.
    pub(super) turn: Vector3<f64>,
    /// Velocity of the place of the tube's origin at time 0, by unit of time.
    slide: Vector3<f64>,
}

impl Screw {
    pub(super) fn between(from: Isometry3<f64>, to: &Isometry3<f64>) -> Self {
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
        let way = to.translation.vector - from.translation.vector;
        let half = turn.cross(&way) * 0.5;
        // The inverse of `V` in closed form, so that no system is solved.
        let slide = way - half + turn.cross(&turn.cross(&way)) * inverse_factor(turn.norm());
        Self { from, turn, slide }
    }

    /// The pose at a time.
    pub(super) fn pose(&self, time: f64) -> Isometry3<f64> {
        let turn = self.turn * time;
        let origin = self.from.translation.vector + carry(&turn) * self.slide * time;
        let rotation = UnitQuaternion::from_scaled_axis(turn) * self.from.rotation;
        Isometry3::from_parts(Translation3::from(origin), rotation)
    }

    /// Velocity of the moving space at a place (world), the same at all times.
    pub(super) fn velocity(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.slide + self.turn.cross(&(x - self.from.translation.vector))
    }
}

fn carry(turn: &Vector3<f64>) -> Matrix3<f64> {
    let angle = turn.norm();
    let square = angle * angle;
    let (first, second) = if angle < SMALL_ANGLE {
        (0.5 - square / 24.0, (1.0 - square / 20.0) / 6.0)
    } else {
        // By the half angle: 1 - cos would cancel.
        let half = (0.5 * angle).sin();
        (2.0 * half * half / square, (angle - angle.sin()) / (square * angle))
    };
    let cross = turn.cross_matrix();
    Matrix3::identity() + cross * first + cross * cross * second
}

/// `(1 - (a/2) cot(a/2)) / a^2`, for `a` up to half a turn.
fn inverse_factor(angle: f64) -> f64 {
    let half = 0.5 * angle;
    if angle < SMALL_ANGLE {
        // The difference below would be left with few digits, as its second number is nearly 1 here.
        1.0 / 12.0 + angle * angle / 720.0
    } else {
        (1.0 - half * half.cos() / half.sin()) / (angle * angle)
    }
}
