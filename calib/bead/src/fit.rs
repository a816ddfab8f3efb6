//! Step 3: the centre to a hundredth of a voxel, by fitting a blurred ball on sloping ground, censored where the scanner
//! clipped.
//!
//! ```text
//! m(x) = b + g . x + A f(x - c; r, p, a)                                                     f of [`super::profile`]
//! ```
//!
//! Eleven numbers: the centre c, ln A, ln r, ln p, ln a, b and g. Where voxels are coarse or clipped the data say little on
//! some of them (A, r and the blur of a small ball are nearly one number), so that the logarithms have a wide normal prior
//! about what is expected of the scanner and the bead: [`Expected`]. A clipped voxel counts only while the model lies below
//! the clipping value. Residuals weigh as Cauchy's, so that bone or air at the window's edge does not draw the centre.

use ::fit::{Damping, End, Limits, Made, Rule, Step, least_squares, median};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::background_field::MODEL_ERROR;
use super::profile::Blur;

const N: usize = 11;
type Vector = SVector<f64, N>;
type Matrix = SMatrix<f64, N, N>;

/// Levenberg-Marquardt steps of one round.
const MAX_STEPS: usize = 100;
/// A step of the centre below this, mm, ends the iteration where the cost has stopped falling too.
const STEP_END_MM: f64 = 1e-6;
/// A fall of the cost below this share of it counts as none: a ten-thousandth of a deviation of any parameter.
const COST_END: f64 = 1e-9;
/// A last step of the centre that is accepted when the steps run out, mm.
pub(crate) const LAST_STEP_MM: f64 = 5e-3;
/// Of the diagonal of the normal equations.
pub(super) const DAMPING: Damping = Damping {
    start: 1e-3,
    rule: Rule::Factors {
        fall: 0.2,
        least: 1e-12,
        rise: 8.0,
        raised: 0.0,
    },
    most: 1e9,
    singular: false,
};
/// Deviations at which a residual counts half.
const HALF_WEIGHT_DEVIATIONS: f64 = 4.0;
/// Deviation of the values by their rounding to whole HU.
const LEAST_NOISE_HU: f64 = 0.3;

/// A voxel of the window: its place about the start, mm, in axes of which the third is the slices' normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) place: Vector3<f64>,
    pub(super) hu: f64,
    pub(super) clipped: bool,
}

/// The middle of the priors, and the deviations of the logarithms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    pub(super) blur: Blur,
    pub(super) metal_hu: f64,
    /// Of radius, blur in the plane, blur along the normal, and metal.
    pub(super) deviations: [f64; 4],
    /// Height over the samples' middle to start from, mm.
    pub(super) height_mm: f64,
    /// Of the ground's values, HU.
    pub(super) noise_hu: f64,
    pub(super) ground_hu: f64,
    pub(super) contrast_hu: f64,
}

/// The fitted model; lengths in mm about the start.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitted {
    pub(super) centre: Vector3<f64>,
    /// mm^2.
    pub(super) covariance: Matrix3<f64>,
    pub(super) blur: Blur,
    /// Deviations of ln r, of ln A, and of ln(A r^3): of all the metal.
    pub(super) radius_deviation: f64,
    pub(super) metal_deviation: f64,
    pub(super) mass_deviation: f64,
    pub(super) metal_hu: f64,
    pub(super) ground_hu: f64,
    /// Root mean square residual where the ball's signal is above a tenth of its greatest, HU.
    pub(super) residual_hu: f64,
    /// The model's greatest signal, HU, and what is seen of it below the clipping.
    pub(super) signal_hu: f64,
    pub(super) clipped: usize,
    /// Minus twice the logarithm of the restricted likelihood on a random field, and of the priors, but for a constant; not
    /// of step 3, where bone beside a bead weighs more than what tells one slice's profile from another.
    pub(super) unlikelihood: Option<f64>,
}

impl Expected {
    /// Middle and inverse variances of the priors of ln A, ln r, ln p, ln a.
    pub(super) fn prior(&self) -> ([f64; 4], [f64; 4]) {
        let blur = self.blur;
        let [radius, plane, axial, metal] = self.deviations;
        (
            [self.metal_hu, blur.radius_mm, blur.plane_mm, blur.axial_mm].map(f64::ln),
            [metal, radius, plane, axial].map(|d| 1.0 / (d * d)),
        )
    }
}

/// The model at one voxel: value, signal of the ball, derivatives.
pub(super) struct Modelled {
    value: f64,
    pub(super) signal: f64,
    pub(super) by: Vector,
}

/// The eleven numbers, and the slice's width.
#[derive(Clone, Copy)]
pub(super) struct State {
    x: Vector,
    slice_mm: f64,
}

impl State {
    /// A ball on no ground: its centre, ln A, ln r, ln p, ln a.
    pub(super) fn of_ball(ball: SVector<f64, 7>, slice_mm: f64) -> Self {
        let mut x = Vector::zeros();
        x.fixed_rows_mut::<7>(0).copy_from(&ball);
        Self { x, slice_mm }
    }

    pub(super) fn centre(&self) -> Vector3<f64> {
        Vector3::new(self.x[0], self.x[1], self.x[2])
    }

    pub(super) fn metal_hu(&self) -> f64 {
        self.x[3].exp()
    }

    pub(super) fn blur(&self) -> Blur {
        Blur {
            radius_mm: self.x[4].exp(),
            plane_mm: self.x[5].exp(),
            axial_mm: self.x[6].exp(),
            slice_mm: self.slice_mm,
        }
    }

    pub(super) fn model(&self, blur: &Blur, metal: f64, place: &Vector3<f64>) -> Modelled {
        let x = &self.x;
        let d = place - Vector3::new(x[0], x[1], x[2]);
        let rho = d.x.hypot(d.y);
        let f = blur.at(rho, d.z);
        // On the axis the direction is free and the derivative by it is 0.
        let (ux, uy) = if rho > 0.0 { (d.x / rho, d.y / rho) } else { (0.0, 0.0) };
        let signal = metal * f.value;
        let by = Vector::from([
            -metal * f.by_rho * ux,
            -metal * f.by_rho * uy,
            -metal * f.by_z,
            signal,
            metal * f.by_radius * blur.radius_mm,
            metal * f.by_plane * blur.plane_mm,
            metal * f.by_axial * blur.axial_mm,
            1.0,
            place.x,
            place.y,
            place.z,
        ]);
        Modelled {
            value: x[7] + x[8] * place.x + x[9] * place.y + x[10] * place.z + signal,
            signal,
            by,
        }
    }
}

struct Problem<'a> {
    samples: &'a [Sample],
    prior_mean: [f64; 4],
    /// Inverse variances of ln A, ln r, ln p, ln a.
    prior_weight: [f64; 4],
    noise_hu: f64,
}

/// Fits the model; `None` where it does not settle.
pub(super) fn fit(samples: &[Sample], expected: &Expected) -> Option<Fitted> {
    let (start, prior_weight) = expected.prior();
    let mut problem = Problem {
        samples,
        prior_mean: start,
        prior_weight,
        // At the bare noise most of a ball's voxels would be outliers at the start, and weigh next to nothing.
        noise_hu: expected.noise_hu.max(0.01 * expected.contrast_hu),
    };
    let mut state = State {
        x: Vector::zeros(),
        slice_mm: expected.blur.slice_mm,
    };
    state.x[2] = expected.height_mm;
    state.x.fixed_rows_mut::<4>(3).copy_from_slice(&start);
    state.x[7] = expected.ground_hu;
    state = problem.settle(state)?;
    // Once more with the noise that the window has.
    // The median is hardly moved by what Cauchy's weights take for outliers.
    problem.noise_hu = problem.spread(&state).max(LEAST_NOISE_HU);
    state = problem.settle(state)?;
    problem.result(&state)
}

impl Problem<'_> {
    /// Residual (data minus model) and variance; nothing where the data only say "at least".
    fn residual(&self, sample: &Sample, model: &Modelled) -> (f64, f64) {
        let own = MODEL_ERROR * model.signal;
        let variance = self.noise_hu * self.noise_hu + own * own;
        let residual = sample.hu - model.value;
        if sample.clipped && residual < 0.0 {
            return (0.0, variance);
        }
        (residual, variance)
    }

    fn prior_cost(&self, state: &State) -> f64 {
        (0..4)
            .map(|i| self.prior_weight[i] * (state.x[3 + i] - self.prior_mean[i]).powi(2))
            .sum()
    }

    /// Cauchy's cost of the residuals and the priors'.
    fn cost(&self, state: &State) -> f64 {
        let (blur, metal) = (state.blur(), state.x[3].exp());
        let term = |sample: &Sample| {
            let (residual, variance) = self.residual(sample, &state.model(&blur, metal, &sample.place));
            HALF_WEIGHT_DEVIATIONS
                * HALF_WEIGHT_DEVIATIONS
                * (residual * residual / (variance * HALF_WEIGHT_DEVIATIONS * HALF_WEIGHT_DEVIATIONS)).ln_1p()
        };
        self.samples.iter().map(term).sum::<f64>() + self.prior_cost(state)
    }

    /// `J^T W J` with the priors, `J^T W r`, the weighted squares and the weights' number.
    fn normal(&self, state: &State) -> (Matrix, Vector, f64, f64) {
        let (blur, metal) = (state.blur(), state.x[3].exp());
        let (mut matrix, mut vector, mut squares, mut count) = (Matrix::zeros(), Vector::zeros(), 0.0, 0.0);
        for sample in self.samples {
            let model = state.model(&blur, metal, &sample.place);
            let (residual, variance) = self.residual(sample, &model);
            if residual == 0.0 && sample.clipped {
                continue;
            }
            let robust =
                1.0 / (1.0 + residual * residual / (variance * HALF_WEIGHT_DEVIATIONS * HALF_WEIGHT_DEVIATIONS));
            // The derivative of Cauchy's cost by the square; its second derivative is left out, as it can make the
            // matrix indefinite.
            let weight = robust / variance;
            matrix.ger(weight, &model.by, &model.by, 1.0);
            vector.axpy(weight * residual, &model.by, 1.0);
            squares += weight * residual * residual;
            count += robust;
        }
        for i in 0..4 {
            matrix[(3 + i, 3 + i)] += self.prior_weight[i];
            vector[3 + i] += self.prior_weight[i] * (self.prior_mean[i] - state.x[3 + i]);
        }
        (matrix, vector, squares, count)
    }

    fn settle(&self, state: State) -> Option<State> {
        let end = least_squares(self, state, DAMPING, Limits::steps(MAX_STEPS))?;
        let settled = match end.end {
            End::Settled => true,
            // No step lowers the cost: it is as low as rounding lets it be.
            End::Nowhere => true,
            End::OutOfSteps => end.length < LAST_STEP_MM,
            End::Last | End::Flat | End::Singular => false,
        };
        settled.then_some(end.state)
    }

    /// Deviation of the residuals by their median.
    fn spread(&self, state: &State) -> f64 {
        let (blur, metal) = (state.blur(), state.x[3].exp());
        let residual = |s: &Sample| (s.hu - state.model(&blur, metal, &s.place).value).abs();
        let unclipped = self.samples.iter().filter(|s| !s.clipped);
        // The median of a normal error's size is 0.6745 deviations.
        median(unclipped.map(residual).collect()) / 0.6745
    }

    fn result(&self, state: &State) -> Option<Fitted> {
        let (matrix, _, squares, count) = self.normal(state);
        let inverse = matrix.cholesky()?.inverse();
        // The covariance is that of the residuals found, as the noise of a CT is not known beforehand.
        let scale = squares / (count - N as f64).max(1.0);
        let (blur, metal) = (state.blur(), state.x[3].exp());
        let (signal, residual) = self.quality(state);
        let clipped = self.samples.iter().filter(|s| s.clipped).count();
        let x = &state.x;
        let fitted = Fitted {
            centre: Vector3::new(x[0], x[1], x[2]),
            covariance: inverse.fixed_view::<3, 3>(0, 0) * scale,
            blur,
            radius_deviation: inverse[(4, 4)].sqrt(),
            metal_deviation: inverse[(3, 3)].sqrt(),
            // Mass goes with metal and the cube of the radius, which are correlated.
            mass_deviation: (inverse[(3, 3)] + 6.0 * inverse[(3, 4)] + 9.0 * inverse[(4, 4)])
                .max(0.0)
                .sqrt(),
            metal_hu: metal,
            ground_hu: x[7] + x[8] * x[0] + x[9] * x[1] + x[10] * x[2],
            residual_hu: residual,
            signal_hu: signal,
            clipped,
            unlikelihood: None,
        };
        x.iter().all(|v| v.is_finite()).then_some(fitted)
    }

    /// The greatest signal, and the root mean square residual where it is above a tenth of that.
    fn quality(&self, state: &State) -> (f64, f64) {
        let (blur, metal) = (state.blur(), state.x[3].exp());
        let greatest = metal * blur.value(0.0, 0.0);
        let (mut sum, mut count) = (0.0, 0.0);
        for sample in self.samples {
            let model = state.model(&blur, metal, &sample.place);
            if model.signal > 0.1 * greatest {
                let (residual, _) = self.residual(sample, &model);
                sum += residual * residual;
                count += 1.0;
            }
        }
        (greatest, (sum / f64::max(count, 1.0)).sqrt())
    }
}

impl ::fit::Problem for Problem<'_> {
    type State = State;
    /// Left side and right side, from where a step is made.
    type At = Option<(Matrix, Vector)>;

    fn look(&self, state: &State) -> Option<(f64, Self::At)> {
        Some((self.cost(state), None))
    }

    fn prepare(&self, state: &State, at: &mut Self::At, _steps: usize) -> bool {
        let (matrix, vector, ..) = self.normal(state);
        *at = Some((matrix, vector));
        true
    }

    fn step(&self, state: &State, at: &Self::At, damping: f64) -> Option<Step<State>> {
        let (matrix, vector) = at.as_ref()?;
        let mut damped = *matrix;
        (0..N).for_each(|i| damped[(i, i)] *= 1.0 + damping);
        let step = damped.cholesky()?.solve(vector);
        let x = state.x + step;
        Some(Step {
            to: State { x, ..*state },
            length: step.rows(0, 3).norm(),
            gain: step.dot(vector),
        })
    }

    fn is_settled(&self, made: &Made<'_, State, Self::At>) -> bool {
        made.length < STEP_END_MM && made.from - made.to <= COST_END * (1.0 + made.to)
    }
}
