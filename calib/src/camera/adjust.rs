//! The adjustment: the camera and all poses together, by the method of Levenberg and Marquardt, poses eliminated.
//!
//! Minimised is the sum of `r^T W r`, `r = seen - predicted`, `W` the inverse of the sighting's covariance. A small
//! motion `(w, v)` after the pose turns about the image of the view's middle: `d(R p + t) = -[R p]x w + v`. With the
//! camera's numbers `c` and, per view, `J = d predicted / dc`, `P = d predicted / d(w, v)`,
//!
//! ```text
//! S = sum J^T W J - E H^-1 E^T,   s = sum J^T W r - E H^-1 h,   E = sum J^T W P,  H = sum P^T W P,  h = sum P^T W r   (4)
//! S dc = s,   (w, v) = H^-1 (h - E^T dc)                                                                        (5)
//! ```
//!
//! a system of the camera's ten numbers whatever the number of views; numbers that are held have 1 on the diagonal and
//! nothing beside it.

use geometry::rotation::{Rotation, RotationVector};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

use super::error::CameraRefused;
use super::model::{Camera, PARAMETERS};
use super::predict::{predicted, slopes};
use super::view::{Ready, Station};

/// Steps; ten are usual.
const MAX_STEPS: usize = 100;
/// A step of this many standard deviations is the last.
pub(super) const STEP_END: f64 = 1e-6;
/// Growth of the cost that is rounding.
const FLAT: f64 = 1.0 + 1e-12;
/// A step of so many standard deviations that does not lead down ends on the rounding of the cost.
const FLAT_STEP: f64 = 1e-3;
/// Damping beyond which no step leads down.
const MOST_DAMPING: f64 = 1e16;

/// The camera's numbers.
pub(super) type Numbers = SVector<f64, PARAMETERS>;
/// Their normal equations.
pub(super) type Square = SMatrix<f64, PARAMETERS, PARAMETERS>;
/// The camera's numbers by a pose.
pub(super) type Mixed = SMatrix<f64, PARAMETERS, 6>;

/// Where the grid was in a view: camera's axes from the grid's about the view's middle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    pub(super) turn: Rotation,
    pub(super) shift: Vector3<f64>,
}

impl Pose {
    /// The rotation matrix.
    pub(super) fn matrix(&self) -> Matrix3<f64> {
        let rows = self.turn.matrix().rows();
        Matrix3::from_fn(|i, j| rows[i][j])
    }

    /// `exp(w) R`, `t + v`.
    fn moved(&self, step: &Vector6<f64>) -> Option<Self> {
        let w = step.fixed_rows::<3>(0).into_owned();
        let turn = Rotation::from_vector(RotationVector::new(w.into()).ok()?);
        Some(Self {
            turn: turn * self.turn,
            shift: self.shift + step.fixed_rows::<3>(3),
        })
    }
}

/// A camera and a pose per view.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) camera: Camera,
    pub(super) poses: Vec<Pose>,
}

/// What is adjusted.
pub(super) struct Problem<'a> {
    pub(super) stations: &'a [Station],
    pub(super) free: [bool; PARAMETERS],
}

/// The normal equations of one view.
#[derive(Debug, Clone)]
pub(super) struct Normal {
    /// `sum J^T W J`.
    own: Square,
    /// `sum J^T W r`.
    pull: Numbers,
    /// `E`.
    pub(super) mixed: Mixed,
    /// `H`.
    pub(super) pose: Matrix6<f64>,
    /// `h`.
    turn: Vector6<f64>,
}

/// Where the iteration ended.
pub(super) struct Settled {
    pub(super) state: State,
    pub(super) normals: Vec<Normal>,
    pub(super) cost: f64,
    pub(super) steps: usize,
}

/// What a step led to.
enum Down {
    /// A state, its cost, and the step's length in standard deviations; infinite where the step was damped.
    To(State, f64, f64),
    /// The steps are nothing, and so is what they change.
    Flat,
    /// None leads down.
    Nowhere,
}

impl Normal {
    fn of(station: &Station, camera: &Camera, pose: &Pose, free: &[bool; PARAMETERS]) -> Self {
        let turn = pose.matrix();
        let mut sums = Self {
            own: Square::zeros(),
            pull: Numbers::zeros(),
            mixed: Mixed::zeros(),
            pose: Matrix6::zeros(),
            turn: Vector6::zeros(),
        };
        for s in &station.sightings {
            let residual = s.pixel - predicted(s, camera, &turn, pose);
            let (mut by_numbers, by_pose) = slopes(s, camera, &turn, pose);
            for k in (0..PARAMETERS).filter(|k| !free[*k]) {
                by_numbers.column_mut(k).fill(0.0);
            }
            let (numbers, motion) = (
                by_numbers.transpose() * s.information,
                by_pose.transpose() * s.information,
            );
            sums.own += numbers * by_numbers;
            sums.pull += numbers * residual;
            sums.mixed += numbers * by_pose;
            sums.pose += motion * by_pose;
            sums.turn += motion * residual;
        }
        sums
    }

    /// `H^-1`, its diagonal grown by the share `damping`; none where the discs do not hold the pose.
    pub(super) fn inverse(&self, damping: f64) -> Option<Matrix6<f64>> {
        let mut pose = self.pose;
        pose.set_diagonal(&(self.pose.diagonal() * (1.0 + damping)));
        pose.cholesky().map(|c| c.inverse())
    }
}

/// `S` and `s` of (4), with the inverses of the poses' parts; `S` has 1 for each number that is held.
pub(super) struct Reduced {
    pub(super) matrix: Square,
    vector: Numbers,
    inverses: Vec<Matrix6<f64>>,
}

impl Reduced {
    pub(super) fn of(normals: &[Normal], free: &[bool; PARAMETERS], damping: f64) -> Option<Self> {
        let (mut matrix, mut vector) = (Square::zeros(), Numbers::zeros());
        let mut inverses = Vec::with_capacity(normals.len());
        for n in normals {
            let inverse = n.inverse(damping)?;
            let carried = n.mixed * inverse;
            let own = n.own + Square::from_diagonal(&(n.own.diagonal() * damping));
            matrix += own - carried * n.mixed.transpose();
            vector += n.pull - carried * n.turn;
            inverses.push(inverse);
        }
        for k in (0..PARAMETERS).filter(|k| !free[*k]) {
            matrix[(k, k)] = 1.0;
        }
        Some(Self {
            matrix,
            vector,
            inverses,
        })
    }
}

impl Problem<'_> {
    /// Squared residuals in units of their deviations, by view and sighting; NaN where nothing is seen.
    pub(super) fn squares(&self, state: &State) -> Vec<Vec<f64>> {
        let one = |(station, pose): (&Station, &Pose)| {
            let turn = pose.matrix();
            let square = |s: &Ready| {
                let r = s.pixel - predicted(s, &state.camera, &turn, pose);
                r.dot(&(s.information * r))
            };
            station.sightings.iter().map(square).collect()
        };
        self.stations.iter().zip(&state.poses).map(one).collect()
    }

    /// Sum of the squares; infinite where a disc is seen nowhere.
    pub(super) fn cost(&self, state: &State) -> f64 {
        let sum: f64 = self.squares(state).iter().flatten().sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    fn normals(&self, state: &State) -> Vec<Normal> {
        let both = self.stations.iter().zip(&state.poses);
        both.map(|(s, p)| Normal::of(s, &state.camera, p, &self.free)).collect()
    }

    /// Adjusts from `state` until a step is nothing beside its standard deviation.
    pub(super) fn settle(&self, state: State) -> Result<Settled, CameraRefused> {
        self.settle_to(STEP_END, 1e-3, state)
    }

    /// Adjusts from a `state` near the end until a step is below `end` standard deviations.
    pub(super) fn settle_to(&self, end: f64, damping: f64, mut state: State) -> Result<Settled, CameraRefused> {
        let (mut damping, mut last) = (damping, f64::INFINITY);
        let mut cost = self.cost(&state);
        for steps in 1..=MAX_STEPS {
            let normals = self.normals(&state);
            if last <= end {
                return Ok(Settled {
                    state,
                    normals,
                    cost,
                    steps,
                });
            }
            match self.downhill(&state, &normals, cost, &mut damping) {
                Down::To(next, next_cost, length) => (state, cost, last) = (next, next_cost, length),
                Down::Flat => last = 0.0,
                Down::Nowhere => return Err(CameraRefused::NoConvergence { steps, last }),
            }
        }
        Err(CameraRefused::NoConvergence { steps: MAX_STEPS, last })
    }

    /// The first step that leads down while the damping grows.
    fn downhill(&self, state: &State, normals: &[Normal], cost: f64, damping: &mut f64) -> Down {
        while *damping <= MOST_DAMPING {
            if let Some((next, length)) = self.stepped(state, normals, *damping) {
                let next_cost = self.cost(&next);
                if next_cost <= cost * FLAT {
                    // A damped step is short however far the end is.
                    let length = if *damping < 1e-6 { length } else { f64::INFINITY };
                    *damping = if *damping < 1e-9 { 0.0 } else { *damping * 0.05 };
                    return Down::To(next, next_cost, length);
                }
                if *damping < 1e-6 && length <= FLAT_STEP {
                    return Down::Flat;
                }
            }
            *damping = (*damping * 10.0).max(1e-6);
        }
        Down::Nowhere
    }

    /// The state after the step (5), and the step's length in standard deviations.
    fn stepped(&self, state: &State, normals: &[Normal], damping: f64) -> Option<(State, f64)> {
        let reduced = Reduced::of(normals, &self.free, damping)?;
        let step: Numbers = reduced.matrix.cholesky()?.solve(&reduced.vector);
        let mut poses = Vec::with_capacity(normals.len());
        let mut decrement = 0.0;
        for ((n, inverse), pose) in normals.iter().zip(&reduced.inverses).zip(&state.poses) {
            let motion = inverse * (n.turn - n.mixed.transpose() * step);
            decrement += step.dot(&n.pull) + motion.dot(&n.turn);
            poses.push(pose.moved(&motion)?);
        }
        let numbers = Numbers::from(state.camera.numbers()) + step;
        let good = numbers[0] > 0.0 && numbers[1] > 0.0 && numbers.iter().all(|x| x.is_finite());
        let camera = good.then(|| Camera::from_numbers(numbers.into()))?;
        Some((State { camera, poses }, decrement.max(0.0).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};

    fn state() -> (Camera, Pose, Ready) {
        let camera = Camera::from_numbers([1500.0, 1480.0, 640.0, 360.0, 2.0, -0.3, 0.1, 0.004, -0.003, 0.02]);
        let pose = Pose {
            turn: Rotation::from_vector(RotationVector::new([0.5, -0.6, 0.2]).unwrap()),
            shift: Vector3::new(4.0, -7.0, 120.0),
        };
        let seen = Ready {
            disc: 0,
            place: Vector3::new(25.0, -18.0, 0.0),
            pixel: Vector2::zeros(),
            information: Matrix2::identity(),
            radius_mm: None,
        };
        (camera, pose, seen)
    }

    /// Central differences of numbers of 1e3 with steps of 1e-5: rounding 1e-13 / 1e-5 and third derivatives h^2 x 1e3.
    #[test]
    fn derivatives_are_those_of_differences() {
        let (camera, pose, seen) = state();
        let h = 1e-5;
        for radius_mm in [None, Some(1.4), Some(9.0)] {
            let seen = Ready { radius_mm, ..seen };
            let (by_numbers, by_pose) = slopes(&seen, &camera, &pose.matrix(), &pose);
            let image = |camera: &Camera, step: Vector6<f64>| {
                let moved = pose.moved(&step).unwrap();
                predicted(&seen, camera, &moved.matrix(), &moved)
            };
            for k in 0..6 {
                let step = Vector6::ith(k, h);
                let by = (image(&camera, step) - image(&camera, -step)) / (2.0 * h);
                assert!((by_pose.column(k) - by).norm() < 1e-6 * by.norm().max(1.0), "{k}: {by}");
            }
            for k in 0..PARAMETERS {
                let moved = |d: f64| {
                    let mut numbers = camera.numbers();
                    numbers[k] += d;
                    image(&Camera::from_numbers(numbers), Vector6::zeros())
                };
                let by = (moved(h) - moved(-h)) / (2.0 * h);
                assert!(
                    (by_numbers.column(k) - by).norm() < 1e-6 * by.norm().max(1.0),
                    "{k}: {by}"
                );
            }
        }
    }
}
