//! The place of the base for touches whose features are known: Levenberg-Marquardt on six numbers.
//!
//! A touch `p` is held along an axis `e` of the base at the point `o` of the base: `r = R e . (p - (R o + t))`, one axis
//! on the plane, two across a groove. For a small motion `(w, v)` of the base after the pose, turning about the origin
//! of the touches' axes, which lies at their mean,
//!
//! ```text
//! dr = (R e x p) . w - (R e) . v                                                                                (1)
//! ```
//!
//! which depends on neither `o` nor the pose's translation.

use fit::{Damping, End, Limits, Problem, Rule, Step, least_squares};
use geometry::motion::{Motion, Pose};
use geometry::rotation::Rotation;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::free_motion::FreeMotion;

/// What holds a touch: its axes and a point, in the base.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    pub(super) axes: [Vector3<f64>; 2],
    /// How many of the axes count.
    pub(super) count: usize,
    pub(super) at: Vector3<f64>,
    /// A groove's direction and its length from `at`, mm.
    pub(super) along: Option<(Vector3<f64>, f64)>,
}

impl Hold {
    pub(super) fn axes(&self) -> &[Vector3<f64>] {
        &self.axes[..self.count]
    }
}

/// A touch about the mean of all, and what holds it.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldTouch {
    pub(super) place: Vector3<f64>,
    pub(super) hold: Hold,
    /// Covariance in units of the noise given; `None` for that noise.
    pub(super) noise: Option<Matrix3<f64>>,
}

impl HeldTouch {
    /// The axes that hold the touch, in the touches' axes and in units of its own noise along them: `L^-1 (R e)` with
    /// `L L^T` the covariance of the residuals. `None` where that is none.
    fn weighed(&self, r: &Matrix3<f64>) -> Option<[Vector3<f64>; 2]> {
        let [a, b] = self.hold.axes.map(|e| r * e);
        let Some(c) = &self.noise else { return Some([a, b]) };
        // L L^T of the 2 x 2 covariance of (a.p, b.p), written out: L = [[first, 0], [below, second]].
        let first = a.dot(&(c * a)).sqrt();
        if self.hold.count == 1 {
            return (first > 0.0).then(|| [a / first, b]);
        }
        let below = a.dot(&(c * b)) / first;
        let second = (b.dot(&(c * b)) - below * below).sqrt();
        (first > 0.0 && second > 0.0).then(|| [a / first, (b - a * (below / first)) / second])
    }

    /// As [`HeldTouch::weighed`]; a direction without noise counts as one of the noise given.
    pub(super) fn rows(&self, r: &Matrix3<f64>) -> [Vector3<f64>; 2] {
        self.weighed(r).unwrap_or_else(|| self.hold.axes.map(|e| r * e))
    }

    /// Distance of the touch from where the base at `pose` holds it, mm; beyond a groove's end the way to the end counts too.
    pub(super) fn off(&self, pose: &Pose) -> f64 {
        // In the base's axes, in which the feature's axes and ends are drawn.
        let back = pose.matrix().transpose() * (self.place - pose.shift) - self.hold.at;
        let across: f64 = self.hold.axes().iter().map(|e| e.dot(&back).powi(2)).sum();
        across.sqrt().hypot(self.beyond(&back))
    }

    /// The same in units of the touch's own deviation times the noise given, mm.
    pub(super) fn counted(&self, pose: &Pose) -> f64 {
        let Some(c) = &self.noise else { return self.off(pose) };
        let r = pose.matrix();
        let off = self.place - pose.shift - r * self.hold.at;
        let across = self.rows(&r)[..self.hold.count]
            .iter()
            .map(|e| e.dot(&off).powi(2))
            .sum::<f64>();
        let way = self.beyond(&(r.transpose() * off));
        let along = self.hold.along.map_or(1.0, |(d, _)| (r * d).dot(&(c * (r * d))).sqrt());
        across.sqrt().hypot(way / along)
    }

    /// How far a place in the base, from where the groove begins, lies beyond the groove's ends, mm.
    fn beyond(&self, back: &Vector3<f64>) -> f64 {
        self.hold.along.map_or(0.0, |(d, length)| {
            let s = d.dot(back);
            // Beyond the far end, before the near one, or between them.
            (s - length).max(-s).max(0.0)
        })
    }
}

/// The derivative (1) for the axis `e` in the touches' axes, with `w` in units of one over the radius.
pub(super) fn row(e: &Vector3<f64>, p: &Vector3<f64>, radius: f64) -> Vector6<f64> {
    let turn = e.cross(p) / radius;
    Vector6::new(turn.x, turn.y, turn.z, -e.x, -e.y, -e.z)
}

/// `J^T W J`, `-J^T W r` and `r^T W r`, the weights by the noise as it lies at the rotation `frozen`.
pub(super) fn normal(
    touches: &[HeldTouch],
    pose: &Pose,
    frozen: &Matrix3<f64>,
    radius: f64,
) -> (Matrix6<f64>, Vector6<f64>, f64) {
    let r = pose.matrix();
    // Frozen weights turn with the base: else the residuals along axes that stay behind would not be those of (1).
    let turned = r * frozen.transpose();
    let (mut matrix, mut vector, mut cost) = (Matrix6::zeros(), Vector6::zeros(), 0.0);
    for touch in touches {
        let off = touch.place - r * touch.hold.at - pose.shift;
        for e in &touch.rows(frozen)[..touch.hold.count] {
            let e = turned * e;
            let (row, residual) = (row(&e, &touch.place, radius), e.dot(&off));
            matrix += row * row.transpose();
            // r + J d is to vanish: J^T J d = -J^T r.
            vector -= row * residual;
            cost += residual * residual;
        }
    }
    (matrix, vector, cost)
}

/// Steps made or tried; five are usual.
const MAX_STEPS: usize = 60;
/// A step below this share of the radius ends the iteration.
const STEP_END: f64 = 1e-12;
/// More damping than this makes a step short however far the end is.
const MOST_AT_END: f64 = 0.1;
/// Of the trace of the normal equations.
const DAMPING: Damping = Damping {
    start: 1e-9,
    rule: Rule::Factors {
        fall: 0.1,
        least: 1e-15,
        rise: 10.0,
        raised: 1e-6,
    },
    most: f64::INFINITY,
    singular: false,
};

/// Times that touches with a noise of their own are weighed anew.
const WEIGHING_ROUNDS: usize = 3;

/// The pose of least squares near `pose`; `None` where it does not settle.
///
/// Weights belong to the rotation, and are frozen while a step looks for less: else the sum would not have to fall.
pub(super) fn settle(touches: &[HeldTouch], mut pose: Pose, radius: f64) -> Option<Pose> {
    let rounds = if touches.iter().any(|t| t.noise.is_some()) {
        WEIGHING_ROUNDS
    } else {
        1
    };
    for _ in 0..rounds {
        let frozen = Frozen {
            touches,
            turn: pose.matrix(),
            radius,
        };
        let settled = least_squares(&frozen, pose, DAMPING, Limits::tries(MAX_STEPS))?;
        // Whatever else it ended by, it is not at the least sum.
        pose = (settled.end == End::Last).then_some(settled.state)?;
    }
    Some(pose)
}

/// Touches with the weights that they have at one rotation.
struct Frozen<'a> {
    touches: &'a [HeldTouch],
    turn: Matrix3<f64>,
    radius: f64,
}

impl Problem for Frozen<'_> {
    type State = Pose;
    type At = (Matrix6<f64>, Vector6<f64>);

    fn look(&self, pose: &Pose) -> Option<(f64, Self::At)> {
        let (matrix, vector, cost) = normal(self.touches, pose, &self.turn, self.radius);
        Some((cost, (matrix, vector)))
    }

    fn step(&self, pose: &Pose, (matrix, vector): &Self::At, damping: f64) -> Option<Step<Pose>> {
        // All unknowns are lengths, so that one share of the trace holds back turns and shifts alike.
        let damped = matrix + Matrix6::identity() * (damping * matrix.trace());
        let step = damped.cholesky()?.solve(vector);
        let to = pose.moved_by(&Motion {
            turn: step.fixed_rows::<3>(0) / self.radius,
            shift: step.fixed_rows::<3>(3).into(),
        })?;
        Some(Step {
            to,
            length: step.norm(),
            gain: step.dot(vector),
        })
    }

    fn is_last(&self, step: &Step<Pose>, _: &Self::At, damping: f64) -> bool {
        // A step that damping alone made short says nothing of how far the end is.
        step.length <= STEP_END * self.radius && damping <= MOST_AT_END
    }
}

/// The translation that fits best for a given rotation, near the one that lays the middles on one another.
pub(super) fn shift(touches: &[HeldTouch], turn: Rotation) -> Vector3<f64> {
    let r = Pose {
        turn,
        shift: Vector3::zeros(),
    }
    .matrix();
    let middle = |h: &Hold| h.at + h.along.map_or_else(Vector3::zeros, |(d, length)| d * (length / 2.0));
    let n = touches.len().max(1) as f64;
    // A plane has no middle: only grooves say where along themselves the base may be.
    let grooves = touches.iter().filter(|t| t.hold.along.is_some());
    let on_grooves = grooves.clone().count().max(1) as f64;
    let first = grooves.map(|t| t.place - r * middle(&t.hold)).sum::<Vector3<f64>>() / on_grooves;
    // A small pull to `first`, so that there is a factor for any layout; it moves what is held by some 1e-6 of the way.
    let (mut matrix, mut vector) = (Matrix3::identity() * (1e-6 * n), Vector3::zeros());
    for t in touches {
        let off = t.place - r * t.hold.at - first;
        for e in t.hold.axes() {
            let e = r * e;
            matrix += e * e.transpose();
            vector += e * e.dot(&off);
        }
    }
    first + matrix.cholesky().map_or_else(Vector3::zeros, |c| c.solve(&vector))
}

/// The ratio of the largest deviation to the least, and the motion of the largest.
pub(super) fn open(normal: &Matrix6<f64>) -> (f64, FreeMotion) {
    let eigen = normal.symmetric_eigen();
    // The eigenvalues are inverse variances: the least belongs to the largest deviation, and their ratio is its square.
    let (least, most) = (eigen.eigenvalues.min().max(0.0), eigen.eigenvalues.max());
    let v = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    let free = FreeMotion {
        turn: [v[0], v[1], v[2]],
        shift: [v[3], v[4], v[5]],
    };
    ((most / least).sqrt(), free)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::rotation::RotationVector;

    /// A plane and one groove leave the way along the groove open: there its middle is laid on that of the touches, however
    /// many touches of the plane come with them.
    #[test]
    fn touches_of_the_plane_do_not_pull_the_groove_to_the_origin() {
        let touch = |axis: Vector3<f64>, place: Vector3<f64>, along| HeldTouch {
            place,
            hold: Hold {
                axes: [axis, Vector3::new(0.0, 1.0, 0.0)],
                count: if along { 2 } else { 1 },
                at: Vector3::zeros(),
                along: along.then(|| (Vector3::new(1.0, 0.0, 0.0), 20.0)),
            },
            noise: None,
        };
        let up = Vector3::new(0.0, 0.0, 1.0);
        let plane = (0..20).map(|i| touch(up, Vector3::new(f64::from(i), 3.0, 5.0), false));
        let groove = (0..30).map(|i| touch(up, Vector3::new(100.0 + f64::from(i % 3) - 1.0, 7.0, 5.0), true));
        let found = shift(
            &plane.chain(groove).collect::<Vec<_>>(),
            Rotation::from_vector(RotationVector::ZERO),
        );
        // The middle of the groove is at x = 10, that of its touches at 100. The small pull is to just there, so that only rounding of
        // 100 mm is left.
        assert!((found - Vector3::new(90.0, 7.0, 5.0)).norm() < 1e-12, "{found}");
    }

    /// So much damping makes any step short: it said "settled" 30 mm from the base's place.
    #[test]
    fn a_step_that_damping_made_short_is_not_the_last() {
        let at = |axis: Vector3<f64>, place: Vector3<f64>| HeldTouch {
            place: place + Vector3::new(30.0, 0.0, 0.0),
            hold: Hold {
                axes: [axis, axis],
                count: 1,
                at: place,
                along: None,
            },
            noise: None,
        };
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        let touches = [at(z, x), at(z, y), at(z, -x), at(x, y), at(x, z), at(y, z)];
        let pose = Pose {
            turn: Rotation::IDENTITY,
            shift: Vector3::zeros(),
        };
        let problem = Frozen {
            touches: &touches,
            turn: pose.matrix(),
            radius: 1.0,
        };
        let (_, equations) = problem.look(&pose).unwrap();
        let step = problem.step(&pose, &equations, 1e14).unwrap();
        assert!(step.length <= STEP_END && !problem.is_last(&step, &equations, 1e14));
        let whole = problem.step(&pose, &equations, 0.0).unwrap();
        assert!((whole.length - 30.0).abs() < 1e-9, "{}", whole.length);
    }

    /// (1) against central differences: the third derivative times h^2 / 6, below 300 mm x 1e-10.
    #[test]
    fn the_derivative_is_that_of_differences() {
        let pose = Pose {
            turn: Rotation::from_vector(RotationVector::new([0.4, 2.1, -0.8]).unwrap()),
            shift: Vector3::new(30.0, -120.0, 55.0),
        };
        let hold = Hold {
            axes: [Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.0, 1.0, 0.0)],
            count: 2,
            at: Vector3::new(-20.0, 14.0, 3.0),
            along: None,
        };
        let (place, radius, h) = (Vector3::new(60.0, 80.0, -25.0), 70.0, 1e-5);
        let residual = |step: Vector6<f64>, e: &Vector3<f64>| {
            let (turn, shift) = (step.fixed_rows::<3>(0) / radius, step.fixed_rows::<3>(3).into());
            let moved = pose.moved_by(&Motion { turn, shift }).unwrap();
            let r = moved.matrix();
            (r * e).dot(&(place - r * hold.at - moved.shift))
        };
        for e in hold.axes() {
            let exact = row(&(pose.matrix() * e), &place, radius);
            for k in 0..6 {
                let step = Vector6::ith(k, h);
                let slope = (residual(step, e) - residual(-step, e)) / (2.0 * h);
                assert!((slope - exact[k]).abs() < 1e-8, "{k}: {slope} {}", exact[k]);
            }
        }
    }
}
