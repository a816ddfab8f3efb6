//! The adjustment: all emitters and all poses together, by Gauss-Newton with damping where a step fails.

use fit::{Damping, End, Limits, Step, least_squares};
use geometry::motion::{Motion, Pose};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3, Vector6};

use super::Refused;
use super::schur::{State, View, gauge, held};
use super::views::{Sighting, Station};

/// Steps made or tried; five or six are usual.
const MAX_STEPS: usize = 60;
/// A step of the emitters (root mean square) and of every pose below this share of the radius ends the iteration.
const STEP_END: f64 = 1e-11;
/// More damping than this makes a step short however far the end is.
const MOST_AT_END: f64 = 0.1;

/// Stations and the columns of their emitters.
pub(super) struct Problem {
    pub(super) stations: Vec<Station>,
    /// The column of each emitter.
    pub(super) columns: Vec<Option<usize>>,
    pub(super) radius: f64,
}

/// Where the iteration ended.
pub(super) struct Settled {
    pub(super) state: State,
    pub(super) matrix: DMatrix<f64>,
    pub(super) gauge: DMatrix<f64>,
    pub(super) steps: usize,
}

impl Problem {
    pub(super) fn residual(&self, s: &Sighting, pose: &Pose, turn: &Matrix3<f64>, state: &State) -> Vector3<f64> {
        let place = self.columns[s.emitter].map_or_else(Vector3::zeros, |c| state.places[c]);
        s.place - turn * place - pose.shift
    }

    /// Squared residuals in units of their deviations, by station and sighting.
    pub(super) fn squares(&self, state: &State) -> Vec<Vec<f64>> {
        let one = |(station, pose): (&Station, &Pose)| {
            let turn = pose.matrix();
            let square = |s: &Sighting| {
                let r = self.residual(s, pose, &turn, state);
                r.dot(&(s.information * r))
            };
            station.sightings.iter().map(square).collect()
        };
        self.stations.iter().zip(&state.poses).map(one).collect()
    }

    /// Sum of the squares.
    pub(super) fn cost(&self, state: &State) -> f64 {
        self.squares(state).iter().flatten().sum()
    }

    fn views(&self, state: &State) -> Option<Vec<View>> {
        let column = |emitter: usize| self.columns[emitter];
        let view = |(station, pose)| View::of(station, pose, column, &state.places, self.radius);
        self.stations.iter().zip(&state.poses).map(view).collect()
    }

    fn reduced(&self, state: &State) -> Option<Reduced> {
        let n = 3 * state.places.len();
        let (mut matrix, mut vector) = (DMatrix::zeros(n, n), DVector::zeros(n));
        // Each view adds its part with its own pose eliminated; only the emitters' 3 N unknowns are ever held together.
        let views = self.views(state)?;
        views.iter().for_each(|v| v.add_to(&mut matrix, &mut vector));
        let gauge = gauge(&state.places);
        Some(Reduced {
            views,
            matrix,
            vector,
            gauge,
        })
    }

    /// Adjusts from `state` until the step vanishes.
    pub(super) fn settle(&self, state: State) -> Result<Settled, Refused> {
        let end = least_squares(self, state, Damping::GAUSS_NEWTON, Limits::tries(MAX_STEPS));
        let refused = |last_mm| Refused::NoConvergence {
            steps: MAX_STEPS,
            last_mm,
        };
        let end = end.ok_or_else(|| refused(f64::INFINITY))?;
        // Formed once more: the equations at hand are those of the state before the last step, the covariance is that
        // of the end.
        let last = (end.end == End::Last).then(|| self.reduced(&end.state)).flatten();
        let Reduced { matrix, gauge, .. } = last.ok_or_else(|| refused(end.length))?;
        Ok(Settled {
            state: end.state,
            matrix,
            gauge,
            steps: end.steps,
        })
    }

    /// The emitters moved by `step`, and each pose by its own.
    fn moved(&self, state: &State, step: &DVector<f64>, pose_steps: &[Vector6<f64>]) -> Option<State> {
        let place = |(i, p): (usize, &Vector3<f64>)| p + step.fixed_rows::<3>(3 * i);
        let pose = |(pose, d): (&Pose, &Vector6<f64>)| {
            pose.moved_in_place(&Motion {
                // The pose's turn is counted in units of 1 / L, as all unknowns are lengths (schur, equation 1).
                turn: d.fixed_rows::<3>(0) / self.radius,
                shift: d.fixed_rows::<3>(3).into_owned(),
            })
        };
        Some(State {
            places: state.places.iter().enumerate().map(place).collect(),
            poses: state.poses.iter().zip(pose_steps).map(pose).collect::<Option<_>>()?,
        })
    }
}

/// The equations of the emitters, with the poses eliminated.
pub(super) struct Reduced {
    views: Vec<View>,
    matrix: DMatrix<f64>,
    vector: DVector<f64>,
    gauge: DMatrix<f64>,
}

impl fit::Problem for Problem {
    type State = State;
    /// None until a step is made from there.
    type At = Option<Reduced>;

    fn look(&self, state: &State) -> Option<(f64, Self::At)> {
        Some((self.cost(state), None))
    }

    fn prepare(&self, state: &State, at: &mut Self::At, _steps: usize) -> bool {
        *at = self.reduced(state);
        at.is_some()
    }

    fn step(&self, state: &State, at: &Self::At, damping: f64) -> Option<Step<State>> {
        let at = at.as_ref()?;
        // S annuls the six motions of the whole marker; s is orthogonal to them, so that holding them leaves the step
        // as it is.
        let (mut system, _) = held(&at.matrix, &at.gauge);
        let extra = at.matrix.diagonal() * damping;
        system.set_diagonal(&(system.diagonal() + extra));
        let step = system.cholesky()?.solve(&at.vector);
        let pose_steps: Vec<Vector6<f64>> = at.views.iter().map(|view| view.pose_step(&step)).collect();
        // Root mean square over the emitters, so that the end does not depend on their number.
        let of_emitters = step.norm() / (state.places.len() as f64).sqrt();
        Some(Step {
            to: self.moved(state, &step, &pose_steps)?,
            // Poses follow undamped: emitters that stand still do not mean that the poses do.
            length: pose_steps.iter().map(Vector6::norm).fold(of_emitters, f64::max),
            gain: step.dot(&at.vector),
        })
    }

    fn is_last(&self, step: &Step<State>, _: &Self::At, damping: f64) -> bool {
        // A step that damping alone made short says nothing of how far the end is.
        step.length <= STEP_END * self.radius && damping <= MOST_AT_END
    }
}
