//! Stage 3: the centre once more by generalised least squares, with the ground as a random field ([`super::ground`]).
//!
//! The fit of stage 2 takes the residuals of voxels for independent, and bone beside a bead draws its centre. Here they
//! have the covariance V of the field, of which the likeliest deviations are found first:
//!
//! ```text
//! minimise  (I - m)^T V^-1 (I - m) + prior,    m(x) = b + A f(x - c; r, p, a)
//! ```
//!
//! V depends on the ball's share of each voxel, and is formed anew in each of three rounds. Voxels that the scanner clipped
//! count only where the model and the field about them predict less than the clipping value; those count as of that value.
//! The covariance of the centre is that of the normal equations: V is known, so nothing is scaled afterwards.
//!
//! Cost: at most 900 voxels in V and 300 in the likelihood, some tenths of a second.

use nalgebra::{DMatrix, DVector, Dyn, Matrix3, Vector3, linalg::Cholesky};

use super::fit::{Expected, Fitted, Sample, State};
use super::ground::{Ground, Linear, Seen, Spread};

/// The most voxels in the covariance, and in the likelihood.
const MAX_VOXELS: usize = 900;
const LIKELIHOOD_VOXELS: usize = 300;
/// Numbers of the ball: centre, ln A, ln r, ln p, ln a.
const BALL: usize = 7;
/// Linearisations of the covariance, and steps within one.
const ROUNDS: usize = 3;
const MAX_STEPS: usize = 30;
/// A step of the centre below this, mm, ends a round.
const STEP_END_MM: f64 = 1e-5;
/// HU over the model of stage 2: another piece of metal, which no field of tissue explains.
const OTHER_METAL_HU: f64 = 1500.0;
/// Length by which the polynomials' variables are divided, mm.
const SCALE_MM: f64 = 3.0;

/// What the refinement gives; lengths in mm about the start of stage 2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Refined {
    pub(super) centre: Vector3<f64>,
    /// mm^2.
    pub(super) covariance: Matrix3<f64>,
}

/// The centre with the ground as a random field or a polynomial; `None` where that does not settle.
pub(super) fn refine(
    samples: &[Sample],
    first: &Fitted,
    expected: &Expected,
    clip_hu: Option<i16>,
    ground: Ground,
) -> Option<Refined> {
    let refiner = Refiner::new(samples, first, expected, clip_hu, ground);
    let start = refiner.start(first);
    let spread = refiner.spread(&start);
    let mut found = (start, Matrix3::zeros());
    for _ in 0..ROUNDS {
        found = refiner.round(&found.0, &spread)?;
    }
    let (state, covariance) = found;
    let centre = Vector3::new(state[0], state[1], state[2]);
    let sound = state.iter().chain(covariance.iter()).all(|v| v.is_finite());
    sound.then_some(Refined { centre, covariance })
}

struct Refiner<'a> {
    /// Voxels below the clipping value, and those at it.
    open: Vec<Sample>,
    clipped: Vec<Sample>,
    expected: &'a Expected,
    clip_hu: f64,
    ground: Ground,
}

impl<'a> Refiner<'a> {
    fn new(samples: &[Sample], first: &Fitted, expected: &'a Expected, clip_hu: Option<i16>, ground: Ground) -> Self {
        let tissue = |s: &&Sample| {
            let d = s.place - first.centre;
            let model = first.ground_hu + first.metal_hu * first.blur.value(d.x.hypot(d.y), d.z);
            s.hu - model < OTHER_METAL_HU
        };
        let thinned = samples.iter().step_by(samples.len().div_ceil(MAX_VOXELS).max(1));
        let (clipped, open) = thinned.filter(tissue).partition(|s| s.clipped);
        Self {
            open,
            clipped,
            expected,
            clip_hu: clip_hu.map_or(f64::INFINITY, f64::from),
            ground,
        }
    }

    fn unknowns(&self) -> usize {
        BALL + self.ground.coefficients()
    }

    fn start(&self, first: &Fitted) -> DVector<f64> {
        let mut state = DVector::zeros(self.unknowns());
        let blur = first.blur;
        let ball = [first.metal_hu, blur.radius_mm, blur.plane_mm, blur.axial_mm].map(f64::ln);
        state.rows_mut(0, 3).copy_from(&first.centre);
        state.rows_mut(3, 4).copy_from_slice(&ball);
        state[BALL] = first.ground_hu;
        state
    }

    /// The ground's deviations, from voxels all over the window.
    fn spread(&self, state: &DVector<f64>) -> Spread {
        let few: Vec<Sample> = self
            .open
            .iter()
            .step_by(self.open.len().div_ceil(LIKELIHOOD_VOXELS).max(1))
            .copied()
            .collect();
        let start = Spread {
            smooth_hu: self.expected.noise_hu.max(1.0),
            noise_hu: (0.3 * self.expected.noise_hu).max(1.0),
        };
        let linear = self.linear(&few, state);
        linear.likeliest(&self.seen(&few, state), start, self.ground)
    }

    /// The voxels with the ball's share of each.
    fn seen(&self, samples: &[Sample], state: &DVector<f64>) -> Vec<Seen> {
        let ball = ball(state, self.expected.blur.slice_mm);
        let (blur, metal) = (ball.blur(), ball.metal_hu());
        let one = |s: &Sample| {
            let d = s.place - ball.centre();
            let share = blur.value(d.x.hypot(d.y), d.z);
            Seen {
                place: s.place,
                share,
                signal: share * metal,
            }
        };
        samples.iter().map(one).collect()
    }

    /// Residuals and derivatives at a state, and the prior of the ball's numbers.
    fn linear(&self, samples: &[Sample], state: &DVector<f64>) -> Linear {
        let n = self.unknowns();
        let mut derivatives = DMatrix::zeros(samples.len(), n);
        let mut residuals = DVector::zeros(samples.len());
        let ball = ball(state, self.expected.blur.slice_mm);
        let (blur, metal) = (ball.blur(), ball.metal_hu());
        for (i, sample) in samples.iter().enumerate() {
            let model = ball.model(&blur, metal, &sample.place);
            let terms = polynomial(&sample.place);
            let ground: f64 = terms.iter().zip(state.iter().skip(BALL)).map(|(t, x)| t * x).sum();
            residuals[i] = sample.hu - ground - model.signal;
            (0..BALL).for_each(|j| derivatives[(i, j)] = model.by[j]);
            (BALL..n).for_each(|j| derivatives[(i, j)] = terms[j - BALL]);
        }
        let (mean, weight) = self.expected.prior();
        let mut linear = Linear {
            residuals,
            derivatives,
            prior_weight: DVector::zeros(n),
            prior_offset: DVector::zeros(n),
        };
        for i in 0..4 {
            linear.prior_weight[3 + i] = weight[i];
            linear.prior_offset[3 + i] = mean[i] - state[3 + i];
        }
        linear
    }

    /// Settles with the covariance that the state gives.
    fn round(&self, start: &DVector<f64>, spread: &Spread) -> Option<(DVector<f64>, Matrix3<f64>)> {
        let open = spread.factor(&self.seen(&self.open, start))?;
        let mut samples = self.open.clone();
        samples.extend(self.dimmed(start, spread, &open));
        let factor = match samples.len() == self.open.len() {
            true => open,
            false => spread.factor(&self.seen(&samples, start))?,
        };
        self.settle(&samples, start, &factor)
    }

    /// The clipped voxels for which less than the clipping value is predicted: as of that value.
    fn dimmed(&self, state: &DVector<f64>, spread: &Spread, open: &Cholesky<f64, Dyn>) -> Vec<Sample> {
        let weights = open.solve(&self.linear(&self.open, state).residuals);
        let around = self.seen(&self.open, state);
        let own = self.linear(&self.clipped, state);
        let predicted_less = |(i, at): (usize, &Seen)| {
            let field: f64 = around
                .iter()
                .zip(weights.iter())
                .map(|(s, w)| spread.between(at, s) * w)
                .sum();
            // The residual is the data's minus the model's, and the data are the clipping value.
            own.residuals[i] - field > 0.0
        };
        let at = self.seen(&self.clipped, state);
        let chosen = at.iter().enumerate().map(predicted_less);
        self.clipped
            .iter()
            .zip(chosen)
            .filter(|(_, less)| *less)
            .map(|(sample, _)| Sample {
                hu: self.clip_hu,
                ..*sample
            })
            .collect()
    }

    /// Levenberg's and Marquardt's steps.
    fn settle(
        &self,
        samples: &[Sample],
        start: &DVector<f64>,
        factor: &Cholesky<f64, Dyn>,
    ) -> Option<(DVector<f64>, Matrix3<f64>)> {
        let (mut state, mut damping) = (start.clone(), 1e-3);
        let mut here = self.evaluated(samples, &state, factor)?;
        for _ in 0..MAX_STEPS {
            let mut damped = here.matrix.clone();
            (0..state.len()).for_each(|i| damped[(i, i)] *= 1.0 + damping);
            let step = damped.cholesky()?.solve(&here.vector);
            let next = &state + &step;
            let there = self.evaluated(samples, &next, factor)?;
            // A NaN is no fall.
            if there.cost <= here.cost * (1.0 + 1e-12) {
                (state, here) = (next, there);
                damping = (damping * 0.2).max(1e-12);
                if step.rows(0, 3).norm() < STEP_END_MM {
                    break;
                }
            } else {
                damping *= 8.0;
                if damping > 1e9 {
                    break;
                }
            }
        }
        let inverse = here.matrix.cholesky()?.inverse();
        Some((state, inverse.fixed_view::<3, 3>(0, 0).into_owned()))
    }

    fn evaluated(&self, samples: &[Sample], state: &DVector<f64>, factor: &Cholesky<f64, Dyn>) -> Option<Evaluated> {
        let linear = self.linear(samples, state);
        let (matrix, vector, squares) = linear.normal(factor)?;
        let prior: f64 = (3..BALL)
            .map(|i| linear.prior_weight[i] * linear.prior_offset[i].powi(2))
            .sum();
        Some(Evaluated {
            matrix,
            vector,
            cost: squares + prior,
        })
    }
}

struct Evaluated {
    matrix: DMatrix<f64>,
    vector: DVector<f64>,
    cost: f64,
}

/// The ball alone, on no ground.
fn ball(state: &DVector<f64>, slice_mm: f64) -> State {
    State::of_ball(state.fixed_rows::<BALL>(0).into_owned(), slice_mm)
}

/// 1, x, y, z, x^2, y^2, z^2, x y, x z, y z, in units of 3 mm.
fn polynomial(place: &Vector3<f64>) -> [f64; 10] {
    let [x, y, z] = (place / SCALE_MM).into();
    [1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
}
