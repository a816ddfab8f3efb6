//! The adjustment of camera, plate, poses and the plate's field (11) together.
//!
//! With `b` the coefficients of the field's waves, `a` those of (11), `t` the prior standard deviation of the field in height
//! or in the plane, and `s^2` the variance factor, that of the residuals in units of the deviations given,
//!
//! ```text
//! sum r^T W r + s^2 sum b^2 / t^2,   b = t a                                                                    (12)
//! ```
//!
//! is made least, and `s` and both `t` are those of the greatest restricted likelihood, by MacKay's rounds: with `C` the
//! covariance of the coefficients `b` of one `t`, `m` their count, and `n` coordinates less the unknowns beside the field
//!
//! ```text
//! g = m - tr C / t^2,     t^2 = sum b^2 / g,     s^2 = sum r^T W r / (n - sum g)                               (13)
//! ```
//!
//! but `s` at least 1. `g` is the effective number of parameters: how many coefficients the discs themselves have fixed. Only
//! where `t` starts and its bounds are chosen, the same for all plates: a plate without a field ends with a `t` of next to
//! nothing.

use fit::{Damping, End, Limits, Made, Rule, Step, least_squares};
use nalgebra::{DMatrix, DVector, Vector6};

use super::adjust::Problem;
use super::error::CameraRefused;
use super::fitted::Field;
use super::normal::{HELD, Numbers, loosest, roots};
use super::paraboloid::SHARED;
use super::plate_field::Waves;
use super::predict::slopes;
use super::state::{State, in_place};
use super::view::Station;

/// Steps of an adjustment and rounds of (13).
const MAX_STEPS: usize = 100;
const MAX_ROUNDS: usize = 100;
/// The last step in standard deviations, times `s`: of an adjustment between rounds, and of the last one.
const ROUGH_STEP_DEVIATIONS: f64 = 0.1;
const LAST_STEP_DEVIATIONS: f64 = 1e-3;
/// So short a last step, in standard deviations times `s`, is accepted where steps ran out in a valley in which progress is
/// slow: some hundredths of what the coefficients are known to.
const SLOW_END: f64 = 0.05;
/// The last change of a `t`, as a share: a hundredth of what `t` is known to.
const LAST_PRIOR_SD_CHANGE: f64 = 0.01;
/// A field of a smaller `t` is none, and its `t` need not converge: no grid is made as well as that, mm.
const NOTHING_MM: f64 = 1e-3;
/// The first `t`, of the height and in the plane, and the least and the greatest, mm.
const START_PRIOR_SD_MM: [f64; 2] = [0.1, 0.05];
const PRIOR_SD_RANGE_MM: [f64; 2] = [1e-5, 10.0];
/// Where the parabola along a step has its minimum before this share of it, the step is shortened to there.
const LEAST_WHOLE_STEP: f64 = 0.8;
/// Of the diagonal of the normal equations.
const DAMPING: Damping = Damping {
    start: MOST_AT_END,
    rule: Rule::Factors {
        fall: 0.05,
        least: 1e-12,
        rise: 10.0,
        raised: 0.0,
    },
    most: 1e12,
    singular: true,
};
/// More damping than this makes a step short however far the minimum is.
const MOST_AT_END: f64 = 1e-6;

/// A state with a field.
#[derive(Clone)]
struct StateWithField {
    state: State,
    coefficients: DVector<f64>,
}

/// A minimum of (12).
struct Minimum {
    at: StateWithField,
    /// Of the normal equations, before the last step.
    matrix: DMatrix<f64>,
    /// `sum r^T W r`.
    squares: f64,
}

/// What is adjusted.
struct Joint<'a> {
    stations: &'a [Station],
    free: [bool; SHARED],
    waves: &'a Waves,
}

/// Adjusts all from `state`, the end of an adjustment without a field.
pub(super) fn adjusted(
    stations: &[Station],
    free: [bool; SHARED],
    waves: &Waves,
    state: State,
) -> Result<(State, Field), CameraRefused> {
    let joint = Joint { stations, free, waves };
    let freedom = joint.freedom();
    let coefficients = DVector::zeros(3 * waves.count());
    let mut at = StateWithField { state, coefficients };
    // At least 1: deviations that are given are enlarged by the residuals, never shrunk.
    let mut variance_factor = (joint.squares(&at) / freedom).max(1.0);
    let (mut prior_sd_mm, mut effective_parameters) = (START_PRIOR_SD_MM, 0.0);
    let mut change = f64::INFINITY;
    for _ in 0..MAX_ROUNDS {
        let end = joint.minimise(
            ROUGH_STEP_DEVIATIONS,
            variance_factor,
            at,
            &joint.prior(prior_sd_mm, variance_factor),
        )?;
        at = end.at;
        let inverse = joint.inverse(&end.matrix, &at)?;
        let next = joint.update_hyperparameters(&at.coefficients, &inverse, prior_sd_mm, variance_factor);
        let changed = |k: usize| {
            if next.0[k] < NOTHING_MM {
                0.0
            } else {
                (next.0[k] / prior_sd_mm[k]).ln().abs()
            }
        };
        change = changed(0).max(changed(1));
        (prior_sd_mm, effective_parameters) = next;
        variance_factor = (end.squares / (freedom - effective_parameters).max(1.0)).max(1.0);
        if change < LAST_PRIOR_SD_CHANGE {
            break;
        }
    }
    // A NaN is no convergence.
    let converged = change < LAST_PRIOR_SD_CHANGE;
    if !converged {
        let [height_mm, plane_mm] = prior_sd_mm;
        return Err(CameraRefused::FieldUnsettled {
            rounds: MAX_ROUNDS,
            height_mm,
            plane_mm,
            change,
        });
    }
    let end = joint.minimise(
        LAST_STEP_DEVIATIONS,
        variance_factor,
        at,
        &joint.prior(prior_sd_mm, variance_factor),
    )?;
    let inverse = joint.inverse(&end.matrix, &end.at)?;
    joint.check_identifiable(&inverse, &end.at)?;
    let field = Field {
        waves: waves.clone(),
        coefficients: end.at.coefficients,
        prior_sd_mm,
        effective_parameters,
        inverse,
    };
    Ok((end.at.state, field))
}

impl Joint<'_> {
    /// Of a system that its priors and the adjustment before have made definite.
    fn inverse(&self, matrix: &DMatrix<f64>, at: &StateWithField) -> Result<DMatrix<f64>, CameraRefused> {
        let found = matrix.clone().cholesky().map(|c| c.inverse());
        found.ok_or_else(|| at.state.free_number(loosest(matrix).1))
    }

    /// Refuses shared numbers that only rounding tells from one another: their errors are correlated to the last digit.
    fn check_identifiable(&self, inverse: &DMatrix<f64>, at: &StateWithField) -> Result<(), CameraRefused> {
        let (least, shared) = loosest(&inverse.view((0, 0), (SHARED, SHARED)).into_owned());
        let is_identifiable = least > HELD;
        if is_identifiable {
            Ok(())
        } else {
            Err(at.state.free_number(shared))
        }
    }

    /// Coordinates less the unknowns beside the field.
    fn freedom(&self) -> f64 {
        let coordinates: usize = self.stations.iter().map(|s| 2 * s.sightings.len()).sum();
        let unknowns = 6 * self.stations.len() + self.free.iter().filter(|f| **f).count();
        coordinates.saturating_sub(unknowns).max(1) as f64
    }

    /// `s^2 / t^2`, the weight of each coefficient's square in (12).
    fn prior(&self, prior_sd_mm: [f64; 2], variance_factor: f64) -> DVector<f64> {
        let m = self.waves.count();
        DVector::from_fn(3 * m, |k, _| variance_factor / prior_sd_mm[usize::from(k >= m)].powi(2))
    }

    /// (13): the next `t`, and the effective number of parameters.
    fn update_hyperparameters(
        &self,
        coefficients: &DVector<f64>,
        inverse: &DMatrix<f64>,
        prior_sd_mm: [f64; 2],
        variance_factor: f64,
    ) -> ([f64; 2], f64) {
        let (m, first) = (self.waves.count(), inverse.nrows() - coefficients.len());
        let mut effective_parameters = 0.0;
        let next = [(0, m, prior_sd_mm[0]), (m, 2 * m, prior_sd_mm[1])].map(|(from, count, sd)| {
            let trace: f64 = (from..from + count).map(|k| inverse[(first + k, first + k)]).sum();
            // The system is that of (12), s^2 times the likelihood's: the covariance C is s^2 times its inverse. Where
            // nothing is fixed the difference is rounding, by which the squares must not be divided.
            let effective = (count as f64 - variance_factor * trace / (sd * sd)).max(1e-6);
            effective_parameters += effective;
            let square = coefficients.rows(from, count).norm_squared() / effective;
            // The prior divides by `t`, which the rounds would take to 0 where there is no field.
            square.sqrt().clamp(PRIOR_SD_RANGE_MM[0], PRIOR_SD_RANGE_MM[1])
        });
        (next, effective_parameters)
    }

    fn problem<'b>(&self, stations: &'b [Station]) -> Problem<'b> {
        let free = self.free;
        Problem { stations, free }
    }

    /// `sum r^T W r`.
    fn squares(&self, at: &StateWithField) -> f64 {
        let stations = self.waves.moved(self.stations, &at.coefficients);
        self.problem(&stations).cost(&at.state)
    }

    /// Minimises (12) to a last step of `last_step` standard deviations times `s`; `variance_factor` is `s^2`.
    fn minimise(
        &self,
        last_step: f64,
        variance_factor: f64,
        at: StateWithField,
        prior: &DVector<f64>,
    ) -> Result<Minimum, CameraRefused> {
        let unit = variance_factor.sqrt();
        let cost = PenalisedCost {
            joint: self,
            prior,
            last_step: last_step * unit,
        };
        let refused = |steps, last| CameraRefused::NoConvergence { steps, last };
        let found = least_squares(&cost, at, DAMPING, Limits::steps(MAX_STEPS));
        let found = found.ok_or_else(|| refused(0, f64::INFINITY))?;
        let slow = found.end == End::OutOfSteps && found.length <= SLOW_END.max(last_step) * unit;
        if !slow && found.end != End::Settled {
            return Err(refused(found.steps, found.length));
        }
        // Of the state before the last step, which is short beside the deviations that the matrix gives.
        let before = found.before.and_then(|at| at.equations);
        let (matrix, _) = before.ok_or_else(|| refused(found.steps, found.length))?;
        Ok(Minimum {
            at: found.state,
            matrix,
            squares: found.at.squares,
        })
    }

    /// The state after a step.
    fn stepped(&self, at: &StateWithField, step: &DVector<f64>) -> Option<StateWithField> {
        let shared = Numbers::from_fn(|k, _| step[k]);
        let turned = at.state.poses.iter().enumerate();
        let poses: Option<Vec<_>> = turned
            .map(|(v, pose)| in_place(pose, &Vector6::from_fn(|k, _| step[SHARED + 6 * v + k])))
            .collect();
        let state = at.state.moved(&shared, poses?)?;
        let coefficients = &at.coefficients + step.rows(step.len() - at.coefficients.len(), at.coefficients.len());
        Some(StateWithField { state, coefficients })
    }

    /// The normal equations of (12): shared numbers, poses, field. Numbers that are held have 1 on the diagonal.
    fn equations(&self, at: &StateWithField, prior: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let (views, waves) = (self.stations.len(), at.coefficients.len());
        let first = SHARED + 6 * views;
        let size = first + waves;
        let (mut matrix, mut vector) = (DMatrix::zeros(size, size), DVector::zeros(size));
        let moved = self.waves.moved(self.stations, &at.coefficients);
        for (view, station) in moved.iter().enumerate() {
            let rows = self.rows(at, view, station);
            let products = rows.transpose() * &rows;
            // A view's rows have shared numbers, its own pose, then the field; the whole has all poses between.
            let place = |k: usize| match k {
                k if k < SHARED => k,
                k if k < SHARED + 6 => k + 6 * view,
                k => k - SHARED - 6 + first,
            };
            let own = SHARED + 6 + waves;
            for j in 0..own {
                vector[place(j)] += products[(own, j)];
                for i in 0..own {
                    matrix[(place(i), place(j))] += products[(i, j)];
                }
            }
        }
        // The prior: each wave is expected to be 0 with its own variance.
        for k in 0..waves {
            matrix[(first + k, first + k)] += prior[k];
            vector[first + k] -= prior[k] * at.coefficients[k];
        }
        for k in (0..SHARED).filter(|k| !self.free[*k]) {
            matrix[(k, k)] = 1.0;
        }
        (matrix, vector)
    }

    /// Derivatives and residuals of a view in units of deviations, two rows a disc.
    fn rows(&self, at: &StateWithField, view: usize, moved: &Station) -> DMatrix<f64> {
        let (eye, m) = (at.state.eye(&at.state.poses[view]), self.waves.count());
        let mut rows = DMatrix::zeros(2 * moved.sightings.len(), SHARED + 6 + 3 * m + 1);
        let both = moved.sightings.iter().zip(self.stations[view].places());
        for (i, (s, at_mm)) in both.enumerate() {
            let (seen, (by_numbers, by_pose)) = slopes(s, &eye);
            // By the disc's place on the plate: the pose's translation turned into the plate's axes.
            let by_place = by_pose.fixed_columns::<3>(3) * eye.turn;
            let [lift, slide] = self.waves.at(at_mm);
            let entry = |row: usize, k: usize| match k {
                k if k < SHARED => f64::from(u8::from(self.free[k])) * by_numbers[(row, k)],
                k if k < SHARED + 6 => by_pose[(row, k - SHARED)],
                k if k < SHARED + 6 + m => by_place[(row, 2)] * lift[k - SHARED - 6],
                k if k < SHARED + 6 + 2 * m => by_place[(row, 0)] * slide[k - SHARED - 6 - m],
                k if k < SHARED + 6 + 3 * m => by_place[(row, 1)] * slide[k - SHARED - 6 - 2 * m],
                _ => s.pixel[row] - seen[row],
            };
            for (r, [a, b]) in roots(&s.information).into_iter().enumerate() {
                for k in 0..rows.ncols() {
                    rows[(2 * i + r, k)] = a * entry(0, k) + b * entry(1, k);
                }
            }
        }
        rows
    }
}

/// (12) for a given prior.
struct PenalisedCost<'a> {
    joint: &'a Joint<'a>,
    prior: &'a DVector<f64>,
    /// A step that is no longer than this, in standard deviations, is the last.
    last_step: f64,
}

/// `sum r^T W r`, and from where a step is made the equations.
struct At {
    squares: f64,
    equations: Option<(DMatrix<f64>, DVector<f64>)>,
}

impl PenalisedCost<'_> {
    fn cost(&self, at: &StateWithField) -> f64 {
        self.joint.squares(at) + prior_cost(at, self.prior)
    }

    /// Where a step leads, or a share of it. Where residuals are large, the second derivatives that the normal equations leave
    /// out are large too, and whole steps may lead to and fro across a valley: where the parabola through the costs at both
    /// ends has its minimum well before the step's end, the step goes there if the cost is lower there than at the end.
    fn line_search(
        &self,
        from: &StateWithField,
        squares: f64,
        step: &DVector<f64>,
        gain: f64,
    ) -> Option<StateWithField> {
        let whole = self.joint.stepped(from, step)?;
        let (start, end) = (squares + prior_cost(from, self.prior), self.cost(&whole));
        // The parabola start - 2 gain t + a t^2 through the cost at the step's end has its least at t = gain / a.
        let share = gain / (end - start + 2.0 * gain);
        // An infinite cost, where a disc is not seen, gives a share of 0: the whole step goes on, and the iteration
        // refuses it.
        if !(share < LEAST_WHOLE_STEP && share > 0.0) {
            return Some(whole);
        }
        let shorter = self.joint.stepped(from, &(step * share));
        Some(shorter.filter(|at| self.cost(at) < end).unwrap_or(whole))
    }
}

impl fit::Problem for PenalisedCost<'_> {
    type State = StateWithField;
    type At = At;

    fn look(&self, at: &StateWithField) -> Option<(f64, At)> {
        let squares = self.joint.squares(at);
        let equations = None;
        Some((squares + prior_cost(at, self.prior), At { squares, equations }))
    }

    fn prepare(&self, state: &StateWithField, at: &mut At, _steps: usize) -> bool {
        at.equations = Some(self.joint.equations(state, self.prior));
        true
    }

    fn step(&self, state: &StateWithField, at: &At, damping: f64) -> Option<Step<StateWithField>> {
        let (matrix, vector) = at.equations.as_ref()?;
        let step = step(matrix, vector, damping)?;
        let gain = step.dot(vector).max(0.0);
        Some(Step {
            to: self.line_search(state, at.squares, &step, gain)?,
            length: if damping <= MOST_AT_END {
                gain.sqrt()
            } else {
                f64::INFINITY
            },
            gain,
        })
    }

    fn is_settled(&self, made: &Made<'_, StateWithField, At>) -> bool {
        made.length <= self.last_step
    }
}

/// The second sum of (12).
fn prior_cost(at: &StateWithField, prior: &DVector<f64>) -> f64 {
    at.coefficients.component_mul(&at.coefficients).dot(prior)
}

/// The step of a system whose diagonal has grown by the share `damping`.
fn step(matrix: &DMatrix<f64>, vector: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let mut damped = matrix.clone();
    damped.set_diagonal(&(matrix.diagonal() * (1.0 + damping)));
    Some(damped.cholesky()?.solve(vector))
}
