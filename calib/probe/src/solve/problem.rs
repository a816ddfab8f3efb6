//! The sum of squares, its normal equations, and the rounds of weights.

use fit::robust::{MEDIAN_CHI2_2, biweight, squared_scale};
use fit::{Damping, Limits, Problem, Step, least_squares};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Matrix3, Matrix6, SMatrix, Vector2, Vector3, Vector6};

use super::frame::{Data, Poses};
use super::options::Options;
use super::state::{Layout, State};
use crate::error::ProbeError;
use crate::free;
use crate::seen::Mark;

/// Median of chi-square with one degree of freedom.
pub(crate) const MEDIAN_CHI2_1: f64 = 0.454_936_423_119_573;
/// A step below this, in deviations of the unknowns, is the last.
const SETTLED: f64 = 1e-4;

/// All that a fit goes by.
pub(crate) struct Solver<'a> {
    pub(crate) data: &'a Data<'a>,
    pub(crate) options: &'a Options,
    pub(crate) layout: Layout,
    /// Inverse of the covariance of the phantom's place, where that is unknown.
    pub(crate) phantom_prior: Matrix6<f64>,
}

/// One point's residual and its derivatives.
pub(crate) struct Row {
    /// Across a wire, mm; of a wall the first alone.
    pub(crate) residual: Vector2<f64>,
    /// By all unknowns.
    pub(crate) unknowns: SMatrixRows,
    /// By the pose's turn and shift.
    pub(crate) pose: SMatrix<f64, 2, 6>,
    /// The point's own covariance.
    pub(crate) noise: Matrix2<f64>,
}

type SMatrixRows = nalgebra::OMatrix<f64, nalgebra::U2, nalgebra::Dyn>;

/// Normal equations of the whole.
pub(crate) struct Sum {
    pub(crate) normal: DMatrix<f64>,
    pub(crate) right: DVector<f64>,
    pub(crate) cost: f64,
    /// Gradient of each frame: what one frame pulls.
    pub(crate) pulls: Vec<DVector<f64>>,
}

/// Where a fit ended.
pub(crate) struct Ended {
    pub(crate) state: State,
    pub(crate) weights: Vec<f64>,
    /// Square of the residuals' scale, of the noise told: at least 1.
    pub(crate) scale: f64,
    pub(crate) is_settled: bool,
}

impl Solver<'_> {
    /// Components of a residual.
    pub(crate) fn components(&self) -> usize {
        if self.layout.wall.is_some() { 1 } else { 2 }
    }

    /// A point's residual, and what moves it.
    pub(crate) fn row(&self, state: &State, poses: &Poses, frame: usize, mark: &Mark) -> Row {
        let pose = &poses.each[frame];
        let image = state.image.matrix();
        let local = Vector3::new(
            (mark.px[0] - self.data.middle[0]) * state.size[0],
            (mark.px[1] - self.data.middle[1]) * state.size[1],
            0.0,
        );
        let arm = image * local;
        let inside = arm + state.image.shift;
        let away = pose.shift - self.data.centre;
        let turned_inside = pose.turn * inside;
        let place = turned_inside + pose.shift + state.tracker * away;
        let mut unknowns = SMatrixRows::zeros(self.layout.len);
        let (residual, by_place) = self.target(state, &place, mark.wire, &mut unknowns);
        let by_inside = by_place * pose.turn;
        // Turn about the middle of the image, shift, and the logarithms of the sizes.
        let by_turn = -by_inside * arm.cross_matrix();
        unknowns.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_turn);
        unknowns.fixed_view_mut::<2, 3>(0, 3).copy_from(&by_inside);
        for k in 0..2 {
            let by_size: Vector2<f64> = by_inside * image.column(k) * local[k];
            unknowns.column_mut(6 + k).copy_from(&by_size);
        }
        if let Some(at) = self.layout.lag {
            let speed = pose.turn_speed * inside + pose.shift_speed + state.tracker * pose.shift_speed;
            unknowns.column_mut(at).copy_from(&(by_place * speed));
        }
        if let Some(at) = self.layout.tracker {
            for i in 0..3 {
                for j in 0..3 {
                    let by: Vector2<f64> = by_place.column(i) * away[j];
                    unknowns.column_mut(at + 3 * i + j).copy_from(&by);
                }
            }
        }
        let mut by_pose = SMatrix::<f64, 2, 6>::zeros();
        by_pose
            .fixed_view_mut::<2, 3>(0, 0)
            .copy_from(&(-by_place * turned_inside.cross_matrix()));
        by_pose.fixed_view_mut::<2, 3>(0, 3).copy_from(&by_place);
        Row {
            residual,
            unknowns,
            pose: by_pose,
            noise: self.noise(&(by_inside * image)),
        }
    }

    /// A point's own covariance across its target.
    fn noise(&self, by_image: &Matrix2x3<f64>) -> Matrix2<f64> {
        let point = self.options.point;
        let variances = Vector3::new(point.lateral_mm, point.axial_mm, point.elevation_mm).map(|s| s * s);
        let mut noise = by_image * Matrix3::from_diagonal(&variances) * by_image.transpose();
        if self.layout.wall.is_some() {
            // The second component of a wall's residual is 0 always: with a variance it says nothing.
            noise[(1, 1)] = 1.0;
        }
        noise
    }

    /// The residual of a place in the reference, its derivative by that place, and by the target's own unknowns.
    fn target(
        &self,
        state: &State,
        place: &Vector3<f64>,
        wire: usize,
        unknowns: &mut SMatrixRows,
    ) -> (Vector2<f64>, Matrix2x3<f64>) {
        if let Some(at) = self.layout.wall {
            let [a, b] = state.wall.across();
            unknowns[(0, at)] = a.dot(place);
            unknowns[(0, at + 1)] = b.dot(place);
            unknowns[(0, at + 2)] = -1.0;
            let residual = Vector2::new(state.wall.normal.dot(place) - state.wall.distance, 0.0);
            return (
                residual,
                Matrix2x3::from_rows(&[state.wall.normal.transpose(), Vector3::zeros().transpose()]),
            );
        }
        let line = &self.data.lines[wire];
        let across = Matrix2x3::from_rows(&[line.across[0].transpose(), line.across[1].transpose()]);
        let (given_turn, given_shift) = &self.data.phantom_from_reference;
        let own = state.phantom_turn();
        let turned_place = own * (given_turn * place + given_shift);
        let there = turned_place + state.phantom.fixed_rows::<3>(3);
        let play = state.play.get(wire).copied().unwrap_or_default();
        let share = line.along.dot(&(there - line.front)) / line.length;
        let slack = Vector2::new(play[0], play[1]) * (1.0 - share) + Vector2::new(play[2], play[3]) * share;
        // The further back a place lies, the more the play there counts.
        let change = Vector2::new(play[2] - play[0], play[3] - play[1]) / line.length;
        let by_there = across - change * line.along.transpose();
        if let Some(at) = self.layout.phantom {
            let w: Vector3<f64> = state.phantom.fixed_rows::<3>(0).into_owned();
            let by_turn = -by_there * turned_place.cross_matrix() * left_jacobian(&w);
            unknowns.fixed_view_mut::<2, 3>(0, at).copy_from(&by_turn);
            unknowns.fixed_view_mut::<2, 3>(0, at + 3).copy_from(&by_there);
        }
        if let Some(at) = self.layout.play {
            for k in 0..2 {
                unknowns[(k, at + 4 * wire + k)] = share - 1.0;
                unknowns[(k, at + 4 * wire + 2 + k)] = -share;
            }
        }
        (across * (there - line.front) - slack, by_there * own * given_turn)
    }

    /// Covariance of the pose's error: the same for all frames.
    fn pose_information(&self) -> Option<Matrix6<f64>> {
        let pose = self.options.pose;
        let variance = |sigma: f64| (sigma * sigma).max(1e-16);
        let (turn, shift) = (1.0 / variance(pose.turn_rad), 1.0 / variance(pose.shift_mm));
        let is_there = pose.turn_rad > 0.0 || pose.shift_mm > 0.0;
        is_there.then(|| Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift)))
    }

    /// Squares of the points' residuals in their own deviations, the pose's noise with them.
    pub(crate) fn squares(&self, state: &State, poses: &Poses) -> Vec<f64> {
        let covariance = self.pose_covariance();
        let mut squares = Vec::new();
        for (frame, seen) in self.data.frames.iter().enumerate() {
            for mark in &seen.marks {
                let row = self.row(state, poses, frame, mark);
                let all = row.noise + row.pose * covariance * row.pose.transpose();
                let square = all
                    .try_inverse()
                    .map_or(f64::INFINITY, |i| row.residual.dot(&(i * row.residual)));
                squares.push(square);
            }
        }
        squares
    }

    /// The square of a row in what its noise, its pose, the image's covariance and the phantom's say of it.
    pub(crate) fn square(&self, image: &SMatrix<f64, 8, 8>, row: &Row, phantom: &Matrix6<f64>) -> f64 {
        let by_image = row.unknowns.fixed_view::<2, 8>(0, 0);
        let mut all = row.noise + row.pose * self.pose_covariance() * row.pose.transpose();
        all += by_image * image * by_image.transpose();
        if let Some(at) = self.layout.phantom {
            let by = row.unknowns.fixed_view::<2, 6>(0, at);
            all += by * phantom * by.transpose();
        }
        all.try_inverse()
            .map_or(f64::INFINITY, |i| row.residual.dot(&(i * row.residual)))
    }

    fn pose_covariance(&self) -> Matrix6<f64> {
        let (turn, shift) = (self.options.pose.turn_rad, self.options.pose.shift_mm);
        Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift).map(|s| s * s))
    }

    /// The normal equations with these weights, the pose's errors of each frame eliminated; what is known before is
    /// in them.
    pub(crate) fn sum(&self, state: &State, poses: &Poses, weights: &[f64]) -> Sum {
        let n = self.layout.len;
        let mut sum = Sum {
            normal: DMatrix::zeros(n, n),
            right: DVector::zeros(n),
            cost: 0.0,
            pulls: Vec::with_capacity(self.data.frames.len()),
        };
        let mut next = 0;
        let information = self.pose_information();
        for (frame, seen) in self.data.frames.iter().enumerate() {
            let mut pull = DVector::zeros(n);
            let mut shared = information.unwrap_or_else(Matrix6::identity);
            let mut mixed = DMatrix::<f64>::zeros(n, 6);
            let mut b = Vector6::zeros();
            for mark in &seen.marks {
                let weight = weights[next];
                next += 1;
                if weight == 0.0 {
                    continue;
                }
                let row = self.row(state, poses, frame, mark);
                let Some(inverse) = row.noise.try_inverse() else {
                    continue;
                };
                let inverse = inverse * weight;
                let weighted = row.unknowns.transpose() * inverse;
                sum.normal += &weighted * &row.unknowns;
                pull -= &weighted * row.residual;
                sum.cost += row.residual.dot(&(inverse * row.residual));
                mixed += &weighted * row.pose;
                shared += row.pose.transpose() * inverse * row.pose;
                b += row.pose.transpose() * inverse * row.residual;
            }
            // The pose's six errors have the prior and their own equations; the best of them are put in (Schur
            // complement).
            if let (Some(_), Some(solved)) = (information, shared.cholesky()) {
                let mixed_out = solved.solve(&mixed.transpose());
                sum.normal -= &mixed * &mixed_out;
                pull += mixed_out.transpose() * b;
                sum.cost -= b.dot(&solved.solve(&b));
            }
            sum.right += &pull;
            sum.pulls.push(pull);
        }
        self.known_before(state, &mut sum);
        sum
    }

    /// What is known before, alone.
    pub(crate) fn prior(&self, state: &State) -> Sum {
        let n = self.layout.len;
        let mut sum = Sum {
            normal: DMatrix::zeros(n, n),
            right: DVector::zeros(n),
            cost: 0.0,
            pulls: Vec::new(),
        };
        self.known_before(state, &mut sum);
        sum
    }

    /// Adds what is known before.
    fn known_before(&self, state: &State, sum: &mut Sum) {
        let priors = self.options.priors;
        let mut add = |at: usize, value: f64, sigma: f64| {
            let weight = 1.0 / (sigma * sigma);
            sum.normal[(at, at)] += weight;
            sum.right[at] -= weight * value;
            sum.cost += weight * value * value;
        };
        if let Some((sizes, relative)) = priors.pixel_mm {
            for (k, (size, known)) in state.size.iter().zip(sizes).enumerate() {
                // Held numbers are held by a deviation of a millionth: the equations stay regular.
                add(6 + k, (size / known).ln(), relative.max(1e-6));
            }
        }
        if let Some(at) = self.layout.lag {
            add(at, state.lag, priors.lag_s);
        }
        if let Some(at) = self.layout.tracker {
            for i in 0..9 {
                add(at + i, state.tracker[(i / 3, i % 3)], priors.tracker);
            }
        }
        if let Some(at) = self.layout.play {
            for (i, play) in state.play.iter().enumerate() {
                for (k, value) in play.iter().enumerate() {
                    add(at + 4 * i + k, *value, priors.play_mm);
                }
            }
        }
        if let Some(at) = self.layout.phantom {
            let pull = self.phantom_prior * state.phantom;
            let mut block = sum.normal.fixed_view_mut::<6, 6>(at, at);
            block += self.phantom_prior;
            let mut right = sum.right.fixed_rows_mut::<6>(at);
            right -= pull;
            sum.cost += state.phantom.dot(&pull);
        }
    }

    /// From a start that graduated weights have found to the end. The scale follows the residuals, so that what is
    /// far off at first is not
    /// let go of for the start's own error.
    pub(crate) fn run(&self, start: State) -> Result<Ended, ProbeError> {
        let median = if self.components() == 1 {
            MEDIAN_CHI2_1
        } else {
            MEDIAN_CHI2_2
        };
        let mut state = start;
        let (mut weights, mut scale) = (Vec::new(), 1.0);
        let mut is_settled = false;
        for _ in 0..self.options.rounds {
            let (squares, now) = self.scaled(&state, median)?;
            scale = now;
            weights = squares.iter().map(|s| biweight(s / scale)).collect();
            let (next, length) = self.fitted(&state, &weights, 1)?;
            state = next;
            // Steps in deviations of the unknowns: nothing that is told changes any more.
            if length < SETTLED {
                is_settled = true;
                break;
            }
        }
        Ok(Ended {
            state,
            weights,
            scale,
            is_settled,
        })
    }

    fn scaled(&self, state: &State, median: f64) -> Result<(Vec<f64>, f64), ProbeError> {
        let squares = self.squares(state, &self.data.poses(state.lag)?);
        let scale = squared_scale(&mut squares.clone(), median, 1.0);
        Ok((squares, scale))
    }

    /// So many steps with fixed weights; and how long the last was, in deviations.
    fn fitted(&self, state: &State, weights: &[f64], steps: usize) -> Result<(State, f64), ProbeError> {
        let weighted = Weighted { solver: self, weights };
        let ended = least_squares(&weighted, state.clone(), Damping::GAUSS_NEWTON, Limits::steps(steps));
        let ended = ended.ok_or(ProbeError::Nowhere)?;
        // Where no step was made, none leads down.
        let length = if ended.steps == 0 { 0.0 } else { ended.length };
        match ended.end {
            fit::End::Singular => Err(ProbeError::Open {
                what: free::open(&ended.at.normal, &ended.state.image.matrix()),
            }),
            _ => Ok((ended.state, length)),
        }
    }
}

/// Derivative of exp(w) at the left.
fn left_jacobian(w: &Vector3<f64>) -> Matrix3<f64> {
    let cross = w.cross_matrix();
    // Its series: the phantom's turn is some degrees, and the fifth power of 0.2 rad over 720 is 4e-7.
    let square = cross * cross;
    Matrix3::identity() + cross / 2.0 + square / 6.0 + square * cross / 24.0 + square * square / 120.0
}

struct Weighted<'a> {
    solver: &'a Solver<'a>,
    weights: &'a [f64],
}

impl Problem for Weighted<'_> {
    type State = State;
    type At = Sum;

    fn look(&self, state: &State) -> Option<(f64, Sum)> {
        let poses = self.solver.data.poses(state.lag).ok()?;
        let sum = self.solver.sum(state, &poses, self.weights);
        sum.cost.is_finite().then_some((sum.cost, sum))
    }

    fn step(&self, state: &State, at: &Sum, damping: f64) -> Option<Step<State>> {
        let mut normal = at.normal.clone();
        for k in 0..normal.nrows() {
            normal[(k, k)] *= 1.0 + damping;
        }
        let step = normal.cholesky()?.solve(&at.right);
        let length = step.dot(&(&at.normal * &step)).max(0.0).sqrt();
        Some(Step {
            to: state.moved(&step, &self.solver.layout)?,
            length,
            gain: at.right.dot(&step),
        })
    }

    fn is_flat(&self, step: &Step<State>, _damping: f64) -> bool {
        step.length < SETTLED
    }
}
