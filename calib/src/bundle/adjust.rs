//! The adjustment: all emitters and all poses together, by Gauss-Newton with damping where a step fails.

use geometry::motion::{Motion, Pose};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::Refused;
use super::schur::{State, View, gauge, held};
use super::views::{Sighting, Station};

/// Steps; five or six are usual.
const MAX_STEPS: usize = 60;
/// A root mean square step below this share of the radius ends the iteration.
const STEP_END: f64 = 1e-11;
/// Growth of the cost that is rounding.
const FLAT: f64 = 1.0 + 1e-12;

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

    fn reduced(&self, state: &State) -> Option<(Vec<View>, DMatrix<f64>, DVector<f64>)> {
        let n = 3 * state.places.len();
        let (mut matrix, mut vector) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let views = self.views(state)?;
        views.iter().for_each(|v| v.add_to(&mut matrix, &mut vector));
        Some((views, matrix, vector))
    }

    /// Adjusts from `state` until the step vanishes.
    pub(super) fn settle(&self, mut state: State) -> Result<Settled, Refused> {
        let mut last_mm = f64::INFINITY;
        let mut damping = 0.0;
        let mut cost = self.cost(&state);
        for steps in 1..=MAX_STEPS {
            let Some((views, matrix, vector)) = self.reduced(&state) else {
                break;
            };
            let gauge = gauge(&state.places);
            if last_mm <= STEP_END * self.radius {
                return Ok(Settled {
                    state,
                    matrix,
                    gauge,
                    steps,
                });
            }
            let (mut system, _) = held(&matrix, &gauge);
            let extra = matrix.diagonal() * damping;
            system.set_diagonal(&(system.diagonal() + extra));
            let Some(step) = system.cholesky().map(|c| c.solve(&vector)) else {
                break;
            };
            let length = step.norm() / (state.places.len() as f64).sqrt();
            let next = self.moved(&state, &views, &step);
            let next_cost = next.as_ref().map_or(f64::INFINITY, |n| self.cost(n));
            match next {
                Some(next) if next_cost <= cost * FLAT || length <= STEP_END * self.radius => {
                    (state, cost, last_mm) = (next, next_cost, length);
                    damping *= 0.1;
                }
                _ => damping = (damping * 10.0_f64).max(1e-3),
            }
        }
        Err(Refused::NoConvergence {
            steps: MAX_STEPS,
            last_mm,
        })
    }

    fn moved(&self, state: &State, views: &[View], step: &DVector<f64>) -> Option<State> {
        let place = |(i, p): (usize, &Vector3<f64>)| p + step.fixed_rows::<3>(3 * i);
        let pose = |(pose, view): (&Pose, &View)| {
            let d = view.pose_step(step);
            pose.moved_in_place(&Motion {
                turn: d.fixed_rows::<3>(0) / self.radius,
                shift: d.fixed_rows::<3>(3).into_owned(),
            })
        };
        Some(State {
            places: state.places.iter().enumerate().map(place).collect(),
            poses: state.poses.iter().zip(views).map(pose).collect::<Option<_>>()?,
        })
    }
}
