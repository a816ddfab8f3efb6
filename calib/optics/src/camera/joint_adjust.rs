//! The adjustment of camera, plate, poses and the plate's field (11) together.
//!
//! With `b` the numbers of the field's waves, `t` times those of (11), `t` the field's size in height or in the plane and
//! `s` the size of the residuals in units of the deviations given,
//!
//! ```text
//! sum r^T W r + s^2 sum b^2 / t^2,   b = t a                                                                    (12)
//! ```
//!
//! is made least, and `s` and both `t` are those of the greatest restricted likelihood, by MacKay's rounds: with `C` the
//! covariance of the numbers `b` of one size, `m` their count, and `n` coordinates less the unknowns beside the field
//!
//! ```text
//! g = m - tr C / t^2,     t^2 = sum b^2 / g,     s^2 = sum r^T W r / (n - sum g)                               (13)
//! ```
//!
//! but `s` at least 1. `g` is how many numbers the discs themselves have fixed. No size is chosen by hand: a plate without
//! a field ends with sizes of nothing.

use fit::{Damping, Limits, Made, Rule, Step, least_squares};
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
/// So short a last step, times `s`, ends a valley in which the way is slow: some hundredths of what the numbers are known to.
const SLOW_END: f64 = 0.05;
/// The last change of a size, as a share: a hundredth of what sizes are known to.
const LAST_SIZE_CHANGE: f64 = 0.01;
/// A field of a smaller size is none, and need not settle: no grid is made as well as that, mm.
const NOTHING_MM: f64 = 1e-3;
/// Sizes to begin with, of the height and in the plane, and the least and the most, mm.
const START_MM: [f64; 2] = [0.1, 0.05];
const SIZES_MM: [f64; 2] = [1e-5, 10.0];
/// A least before this share of a step is gone to.
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
/// More damping than this makes a step short however far the end is.
const MOST_AT_END: f64 = 1e-6;

/// A state with a field.
#[derive(Clone)]
struct StateWithField {
    state: State,
    numbers: DVector<f64>,
}

/// Where an adjustment ended.
struct End {
    at: StateWithField,
    matrix: DMatrix<f64>,
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
    let numbers = DVector::zeros(3 * waves.count());
    let mut at = StateWithField { state, numbers };
    // At least 1: deviations that are given are enlarged by the residuals, never shrunk.
    let mut noise = (joint.squares(&at) / freedom).max(1.0);
    let (mut sizes_mm, mut fixed) = (START_MM, 0.0);
    let mut change = f64::INFINITY;
    for _ in 0..MAX_ROUNDS {
        let end = joint.settled(ROUGH_STEP_DEVIATIONS, noise, at, &joint.prior(sizes_mm, noise))?;
        at = end.at;
        let inverse = joint.inverse(&end.matrix, &at)?;
        let next = joint.round(&at.numbers, &inverse, sizes_mm, noise);
        let changed = |k: usize| {
            if next.0[k] < NOTHING_MM {
                0.0
            } else {
                (next.0[k] / sizes_mm[k]).ln().abs()
            }
        };
        change = changed(0).max(changed(1));
        (sizes_mm, fixed) = next;
        noise = (end.squares / (freedom - fixed).max(1.0)).max(1.0);
        if change < LAST_SIZE_CHANGE {
            break;
        }
    }
    // A NaN is not settled.
    let still = change < LAST_SIZE_CHANGE;
    if !still {
        let [height_mm, plane_mm] = sizes_mm;
        return Err(CameraRefused::FieldUnsettled {
            rounds: MAX_ROUNDS,
            height_mm,
            plane_mm,
            change,
        });
    }
    let end = joint.settled(LAST_STEP_DEVIATIONS, noise, at, &joint.prior(sizes_mm, noise))?;
    let inverse = joint.inverse(&end.matrix, &end.at)?;
    joint.held(&inverse, &end.at)?;
    let field = Field {
        waves: waves.clone(),
        numbers: end.at.numbers,
        sizes_mm,
        fixed,
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

    /// Refuses shared numbers that only rounding tells from one another: their errors go together to the last digit.
    fn held(&self, inverse: &DMatrix<f64>, at: &StateWithField) -> Result<(), CameraRefused> {
        let (least, shared) = loosest(&inverse.view((0, 0), (SHARED, SHARED)).into_owned());
        let held = least > HELD;
        if held {
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

    /// What stands before `b^2` in (12).
    fn prior(&self, sizes_mm: [f64; 2], noise: f64) -> DVector<f64> {
        let m = self.waves.count();
        DVector::from_fn(3 * m, |k, _| noise / sizes_mm[usize::from(k >= m)].powi(2))
    }

    /// (13): the next sizes, and how many numbers are fixed.
    fn round(&self, numbers: &DVector<f64>, inverse: &DMatrix<f64>, sizes_mm: [f64; 2], noise: f64) -> ([f64; 2], f64) {
        let (m, first) = (self.waves.count(), inverse.nrows() - numbers.len());
        let mut all = 0.0;
        let next = [(0, m, sizes_mm[0]), (m, 2 * m, sizes_mm[1])].map(|(from, count, size)| {
            let trace: f64 = (from..from + count).map(|k| inverse[(first + k, first + k)]).sum();
            // The system is that of (12), s^2 times the likelihood's: the covariance C is s^2 times its inverse. Where
            // nothing is fixed the difference is rounding, by which the squares must not be divided.
            let fixed = (count as f64 - noise * trace / (size * size)).max(1e-6);
            all += fixed;
            let square = numbers.rows(from, count).norm_squared() / fixed;
            // The prior divides by the size, which the rounds would take to 0 where there is no field.
            square.sqrt().clamp(SIZES_MM[0], SIZES_MM[1])
        });
        (next, all)
    }

    fn problem<'b>(&self, stations: &'b [Station]) -> Problem<'b> {
        let free = self.free;
        Problem { stations, free }
    }

    /// `sum r^T W r`.
    fn squares(&self, at: &StateWithField) -> f64 {
        let stations = self.waves.moved(self.stations, &at.numbers);
        self.problem(&stations).cost(&at.state)
    }

    /// The least of (12) to a last step of `end` deviations times `s`; `noise` is `s^2`.
    fn settled(&self, end: f64, noise: f64, at: StateWithField, prior: &DVector<f64>) -> Result<End, CameraRefused> {
        let unit = noise.sqrt();
        let likelihood = Likelihood {
            joint: self,
            prior,
            last: end * unit,
        };
        let refused = |steps, last| CameraRefused::NoConvergence { steps, last };
        let found = least_squares(&likelihood, at, DAMPING, Limits::steps(MAX_STEPS));
        let found = found.ok_or_else(|| refused(0, f64::INFINITY))?;
        let slow = found.end == fit::End::OutOfSteps && found.length <= SLOW_END.max(end) * unit;
        if !slow && found.end != fit::End::Settled {
            return Err(refused(found.steps, found.length));
        }
        // Of the state before: the last step is nothing beside the deviations that it says.
        let before = found.before.and_then(|at| at.equations);
        let (matrix, _) = before.ok_or_else(|| refused(found.steps, found.length))?;
        Ok(End {
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
        let numbers = &at.numbers + step.rows(step.len() - at.numbers.len(), at.numbers.len());
        Some(StateWithField { state, numbers })
    }

    /// The normal equations of (12): shared numbers, poses, field. Numbers that are held have 1 on the diagonal.
    fn equations(&self, at: &StateWithField, prior: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let (views, waves) = (self.stations.len(), at.numbers.len());
        let first = SHARED + 6 * views;
        let size = first + waves;
        let (mut matrix, mut vector) = (DMatrix::zeros(size, size), DVector::zeros(size));
        let moved = self.waves.moved(self.stations, &at.numbers);
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
            vector[first + k] -= prior[k] * at.numbers[k];
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

/// (12) for sizes that are given.
struct Likelihood<'a> {
    joint: &'a Joint<'a>,
    prior: &'a DVector<f64>,
    /// The last step, standard deviations.
    last: f64,
}

/// `sum r^T W r`, and from where a step is made the equations.
struct At {
    squares: f64,
    equations: Option<(DMatrix<f64>, DVector<f64>)>,
}

impl Likelihood<'_> {
    fn cost(&self, at: &StateWithField) -> f64 {
        self.joint.squares(at) + weighed(at, self.prior)
    }

    /// Where a step leads, or a share of it. Residuals turn the derivatives, and whole steps may then lead to and fro across a
    /// valley: where the parabola through both ends has its least well before the step's end, the step goes there.
    fn lower(&self, from: &StateWithField, squares: f64, step: &DVector<f64>, gain: f64) -> Option<StateWithField> {
        let whole = self.joint.stepped(from, step)?;
        let (start, end) = (squares + weighed(from, self.prior), self.cost(&whole));
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

impl fit::Problem for Likelihood<'_> {
    type State = StateWithField;
    type At = At;

    fn look(&self, at: &StateWithField) -> Option<(f64, At)> {
        let squares = self.joint.squares(at);
        let equations = None;
        Some((squares + weighed(at, self.prior), At { squares, equations }))
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
            to: self.lower(state, at.squares, &step, gain)?,
            length: if damping <= MOST_AT_END {
                gain.sqrt()
            } else {
                f64::INFINITY
            },
            gain,
        })
    }

    fn is_settled(&self, made: &Made<'_, StateWithField, At>) -> bool {
        made.length <= self.last
    }
}

/// The second sum of (12).
fn weighed(at: &StateWithField, prior: &DVector<f64>) -> f64 {
    at.numbers.component_mul(&at.numbers).dot(prior)
}

/// The step of a system whose diagonal has grown by the share `damping`.
fn step(matrix: &DMatrix<f64>, vector: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let mut damped = matrix.clone();
    damped.set_diagonal(&(matrix.diagonal() * (1.0 + damping)));
    Some(damped.cholesky()?.solve(vector))
}
