//! The adjustment: the camera and all poses together, by the method of Levenberg and Marquardt, poses eliminated.
//!
//! Minimised is the sum of `r^T W r`, `r = seen - predicted`, `W` the inverse of the sighting's covariance. A small
//! motion `(w, v)` after the pose turns about the image of the view's middle: `d(R p + t) = -[R p]x w + v`. With the
//! camera's and the plate's numbers `c` and, per view, `J = d predicted / dc`, `P = d predicted / d(w, v)`,
//!
//! ```text
//! S = sum J^T W J - E H^-1 E^T,   s = sum J^T W r - E H^-1 h,   E = sum J^T W P,  H = sum P^T W P,  h = sum P^T W r   (4)
//! S dc = s,   (w, v) = H^-1 (h - E^T dc)                                                                        (5)
//! ```
//!
//! a system of seventeen numbers whatever the number of views; numbers that are held have 1 on the diagonal and nothing
//! beside it.

use fit::{Damping, End, Limits, Made, Rule, Step, least_squares};
use geometry::motion::Pose;

use super::error::CameraRefused;
use super::full_hessian;
use super::normal::{Normal, Numbers, Reduced};
use super::paraboloid::SHARED;
use super::predict::predicted;
use super::state::{State, in_place};
use super::view::{Ready, Station};

/// Steps; ten are usual.
const MAX_STEPS: usize = 100;
/// After so many the residuals are taken to be what makes the way long, and the second derivative is had in full.
const STEPS_BEFORE_FULL_HESSIAN: usize = 20;
/// A step of this many standard deviations is the last.
pub(super) const STEP_END: f64 = 1e-6;
/// A step of so many standard deviations that does not lead down ends on the rounding of the cost.
const FLAT_STEP: f64 = 1e-3;
/// So short a last step, in standard deviations, ends a valley in which large residuals make the way slow: a hundredth of
/// what the numbers are known to.
const SLOW_END: f64 = 1e-2;
/// More damping than this makes a step short however far the end is.
const MOST_AT_END: f64 = 1e-6;

/// Of the diagonals of the normal equations.
fn damping(start: f64) -> Damping {
    Damping {
        start,
        rule: Rule::Factors {
            fall: 0.05,
            least: 0.0,
            rise: 10.0,
            raised: 1e-6,
        },
        most: 1e16,
        singular: true,
    }
}

/// Rounding of a predicted pixel, relative to its place.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// What is adjusted.
pub(super) struct Problem<'a> {
    pub(super) stations: &'a [Station],
    pub(super) free: [bool; SHARED],
}

/// Where the iteration ended.
pub(super) struct Settled {
    pub(super) state: State,
    pub(super) normals: Vec<Normal>,
    pub(super) cost: f64,
    pub(super) steps: usize,
}

impl Problem<'_> {
    /// Squared residuals in units of their deviations, by view and sighting; NaN where nothing is seen.
    pub(super) fn squares(&self, state: &State) -> Vec<Vec<f64>> {
        let one = |(station, pose): (&Station, &Pose)| {
            let eye = state.eye(pose);
            let square = |s: &Ready| {
                let r = s.pixel - predicted(s, &eye);
                r.dot(&(s.information * r))
            };
            station.sightings.iter().map(square).collect()
        };
        self.stations.iter().zip(&state.poses).map(one).collect()
    }

    /// Root mean square distance, pixels.
    pub(super) fn rms_px(&self, state: &State) -> f64 {
        let one = |(station, pose): (&Station, &Pose)| {
            let eye = state.eye(pose);
            let off = |s: &Ready| (s.pixel - predicted(s, &eye)).norm_squared();
            station.sightings.iter().map(off).sum::<f64>()
        };
        let sum: f64 = self.stations.iter().zip(&state.poses).map(one).sum();
        let discs: usize = self.stations.iter().map(|s| s.sightings.len()).sum();
        (sum / discs.max(1) as f64).sqrt()
    }

    /// Sum of the squares; infinite where a disc is seen nowhere.
    pub(super) fn cost(&self, state: &State) -> f64 {
        let sum: f64 = self.squares(state).iter().flatten().sum();
        // What is not in front of the camera is predicted at NaN: no step may lead there.
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    /// What the rounding of the predictions may make of the sum of squares.
    fn rounding(&self) -> f64 {
        let of = |s: &Ready| s.information.trace() * (ROUNDING * (1.0 + s.pixel.norm())).powi(2);
        let sightings = self.stations.iter().flat_map(|station| &station.sightings);
        sightings.map(of).sum()
    }

    fn normals(&self, state: &State) -> Vec<Normal> {
        let both = self.stations.iter().zip(&state.poses);
        both.map(|(s, p)| Normal::of(s, &state.eye(p), &self.free)).collect()
    }

    /// The normal equations with the second derivative in full.
    fn curved(&self, state: &State, normals: &[Normal]) -> Option<Vec<Normal>> {
        let known = full_hessian::known(normals);
        let each = normals.iter().zip(self.stations).zip(&state.poses);
        each.map(|((n, s), p)| full_hessian::curved(n, s, state, p, (&self.free, &known)))
            .collect()
    }

    /// Adjusts from `state` until a step is nothing beside its standard deviation.
    pub(super) fn settle(&self, state: State) -> Result<Settled, CameraRefused> {
        self.settle_to(STEP_END, 1e-3, state)
    }

    /// Adjusts from a `state` near the end until a step is below `end` standard deviations.
    pub(super) fn settle_to(&self, end: f64, damping: f64, state: State) -> Result<Settled, CameraRefused> {
        let (state, _, steps) = self.descended(end, damping, state)?;
        Ok(self.ended(state, steps))
    }

    /// What is known at the end.
    pub(super) fn ended(&self, state: State, steps: usize) -> Settled {
        Settled {
            normals: self.normals(&state),
            cost: self.cost(&state),
            state,
            steps,
        }
    }

    /// Where the iteration ends, the cost there, and the steps made.
    pub(super) fn descended(&self, end: f64, start: f64, state: State) -> Result<(State, f64, usize), CameraRefused> {
        let descent = Descent { problem: self, end };
        let refused = |steps, last| CameraRefused::NoConvergence { steps, last };
        let found = least_squares(&descent, state, damping(start), Limits::steps(MAX_STEPS));
        let found = found.ok_or_else(|| refused(0, f64::INFINITY))?;
        let settled = match found.end {
            End::Settled | End::Flat => true,
            End::OutOfSteps => found.length <= SLOW_END,
            End::Last | End::Nowhere | End::Singular => false,
        };
        match settled {
            true => Ok((found.state, found.cost, found.steps)),
            false => Err(refused(found.steps, found.length)),
        }
    }

    /// The state after the step (5), and the step's length in standard deviations.
    fn stepped(&self, state: &State, normals: &[Normal], damping: f64) -> Option<Step<State>> {
        let reduced = Reduced::of(normals, &self.free, damping)?;
        let step: Numbers = reduced.matrix.cholesky()?.solve(&reduced.vector);
        let mut poses = Vec::with_capacity(normals.len());
        let mut decrement = 0.0;
        for ((n, inverse), pose) in normals.iter().zip(&reduced.inverses).zip(&state.poses) {
            let motion = inverse * (n.turn - n.mixed.transpose() * step);
            // The gradient times the step: undamped, this is the square of the step's length in standard deviations.
            decrement += step.dot(&n.pull) + motion.dot(&n.turn);
            poses.push(in_place(pose, &motion)?);
        }
        let length = decrement.max(0.0).sqrt();
        Some(Step {
            to: state.moved(&step, poses)?,
            length: if damping < MOST_AT_END { length } else { f64::INFINITY },
            gain: decrement,
        })
    }
}

/// A problem, and the last step in standard deviations.
struct Descent<'a> {
    problem: &'a Problem<'a>,
    end: f64,
}

impl fit::Problem for Descent<'_> {
    type State = State;
    /// None until a step is made from there.
    type At = Vec<Normal>;

    fn look(&self, state: &State) -> Option<(f64, Self::At)> {
        Some((self.problem.cost(state), Vec::new()))
    }

    fn prepare(&self, state: &State, at: &mut Self::At, steps: usize) -> bool {
        *at = self.problem.normals(state);
        let curved = (steps >= STEPS_BEFORE_FULL_HESSIAN)
            .then(|| self.problem.curved(state, at))
            .flatten();
        // It may be indefinite far from the end: Cholesky then fails, and damping by the first term's diagonal makes it
        // definite.
        if let Some(curved) = curved {
            *at = curved;
        }
        true
    }

    fn step(&self, state: &State, at: &Self::At, damping: f64) -> Option<Step<State>> {
        self.problem.stepped(state, at, damping)
    }

    fn is_flat(&self, step: &Step<State>, _: f64) -> bool {
        step.length <= FLAT_STEP
    }

    /// Of discs without an error rounding is left, among which steps find no end.
    fn is_settled(&self, made: &Made<'_, State, Self::At>) -> bool {
        made.length <= self.end || made.to <= self.problem.rounding()
    }
}
