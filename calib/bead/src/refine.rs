//! Step 5: the ball once more by generalised least squares, with the ground as a random field ([`super::background_field`]).
//!
//! The fit of step 3 takes the residuals of voxels for independent, and bone beside a bead draws its centre. Here they
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

use ::fit::{End, Limits, Made, Step, least_squares};
use nalgebra::{DMatrix, DVector, Dyn, Vector3, linalg::Cholesky};

use super::background_field::{Ground, Linear, Spread, VoxelShare};
use super::fit::{DAMPING, Expected, Fitted, LAST_STEP_MM, Sample, State};
use super::residuals::Leftover;

/// The most voxels in the covariance, and in the likelihood.
const MAX_VOXELS: usize = 900;
const LIKELIHOOD_VOXELS: usize = 300;
/// Numbers of the ball: centre, ln A, ln r, ln p, ln a.
const BALL: usize = 7;
const METAL: usize = 3;
const RADIUS: usize = 4;
/// Linearisations of the covariance, and steps within one.
const COVARIANCE_ROUNDS: usize = 3;
const MAX_STEPS: usize = 30;
/// A step of the centre below this, mm, ends a round.
const STEP_END_MM: f64 = 1e-5;
/// HU over the ground: another piece of metal, which no field of tissue explains.
const OTHER_METAL_HU: f64 = 1500.0;
/// The ball's radius beside the expected one and the deviations of its blur, beyond which that is none of its own.
const MAX_RADIUS_RATIO: f64 = 1.25;
const MAX_BLUR_RATIO: f64 = 2.0;
/// Length by which the polynomials' variables are divided, mm.
const SCALE_MM: f64 = 3.0;

/// The ball with the ground as a random field or a polynomial, lengths in mm about the middle of the samples; `None`
/// where that does not converge. It starts from what is expected: beside bone the fit of step 3 may be far off.
pub(super) fn refine<'a>(
    samples: &[Sample],
    expected: &'a Expected,
    clip_hu: Option<i16>,
    ground: Ground,
) -> Option<Refined<'a>> {
    let refiner = Refiner::new(samples, expected, clip_hu, ground);
    let mut state = refiner.start();
    let mut spread = refiner.spread(&state);
    let mut inverse = DMatrix::zeros(0, 0);
    for round in 0..COVARIANCE_ROUNDS {
        (state, inverse) = refiner.minimise_with_covariance_of(&state, &spread)?;
        if round == 0 {
            // Far from the centre the linearised model leaves much to the ground.
            spread = refiner.spread(&state);
        }
    }
    let sound = state.iter().chain(inverse.iter()).all(|v| v.is_finite());
    sound.then_some(Refined {
        refiner,
        state,
        inverse,
        spread,
    })
}

/// A ball on its field.
pub(super) struct Refined<'a> {
    refiner: Refiner<'a>,
    state: DVector<f64>,
    inverse: DMatrix<f64>,
    spread: Spread,
}

impl Refined<'_> {
    pub(super) fn centre(&self) -> Vector3<f64> {
        Vector3::new(self.state[0], self.state[1], self.state[2])
    }

    /// The greatest standard deviation of the centre's coordinates, mm.
    pub(super) fn deviation_mm(&self) -> f64 {
        self.inverse.fixed_view::<3, 3>(0, 0).diagonal().max().max(0.0).sqrt()
    }

    /// What step 3 gives of a ball, here of the ball on its field; `None` where the field's covariance has no factor.
    pub(super) fn fitted(&self) -> Option<Fitted> {
        let Self { refiner, inverse, .. } = self;
        let ball = ball(&self.state, refiner.expected.blur.slice_mm);
        let variance = |i: usize| inverse[(i, i)].max(0.0);
        // The logarithm of all metal is ln A + 3 ln r.
        let mass = variance(METAL) + 6.0 * inverse[(METAL, RADIUS)] + 9.0 * variance(RADIUS);
        Some(Fitted {
            centre: self.centre(),
            covariance: inverse.fixed_view::<3, 3>(0, 0).into_owned(),
            blur: ball.blur(),
            radius_deviation: variance(RADIUS).sqrt(),
            metal_deviation: variance(METAL).sqrt(),
            mass_deviation: mass.max(0.0).sqrt(),
            metal_hu: ball.metal_hu(),
            ground_hu: self.state[BALL],
            residual_hu: self.leftover()?.residual_hu(),
            signal_hu: ball.metal_hu() * ball.blur().value(0.0, 0.0),
            clipped: refiner.clipped.len(),
            unlikelihood: refiner.unlikelihood(&self.state, &self.spread),
        })
    }

    /// What neither ball nor field explains.
    pub(super) fn leftover(&self) -> Option<Leftover> {
        let open = &self.refiner.unclipped;
        let residuals = self.refiner.linear(open, &self.state).residuals;
        Leftover::of(&self.spread, self.refiner.shares(open, &self.state), &residuals)
    }
}

struct Refiner<'a> {
    /// Voxels below the clipping value, and those at it.
    unclipped: Vec<Sample>,
    clipped: Vec<Sample>,
    expected: &'a Expected,
    clip_hu: f64,
    ground: Ground,
}

impl<'a> Refiner<'a> {
    fn new(samples: &[Sample], expected: &'a Expected, clip_hu: Option<i16>, ground: Ground) -> Self {
        let thinned = samples.iter().step_by(samples.len().div_ceil(MAX_VOXELS).max(1));
        let (clipped, unclipped) = thinned.filter(|s| is_tissue(s, expected)).partition(|s| s.clipped);
        Self {
            unclipped,
            clipped,
            expected,
            clip_hu: clip_hu.map_or(f64::INFINITY, f64::from),
            ground,
        }
    }

    fn unknowns(&self) -> usize {
        BALL + self.ground.coefficients()
    }

    /// What is expected, at the height that is expected.
    fn start(&self) -> DVector<f64> {
        let mut state = DVector::zeros(self.unknowns());
        state[2] = self.expected.height_mm;
        state.rows_mut(METAL, 4).copy_from_slice(&self.expected.prior().0);
        state[BALL] = self.expected.ground_hu;
        state
    }

    /// The ground's deviations, from voxels all over the window.
    fn spread(&self, state: &DVector<f64>) -> Spread {
        let few: Vec<Sample> = self
            .unclipped
            .iter()
            .step_by(self.unclipped.len().div_ceil(LIKELIHOOD_VOXELS).max(1))
            .copied()
            .collect();
        let start = Spread {
            // Above 0, which a search by factors would never leave.
            smooth_hu: self.expected.noise_hu.max(1.0),
            noise_hu: (0.3 * self.expected.noise_hu).max(1.0),
        };
        let linear = self.linear(&few, state);
        linear.likeliest(&self.shares(&few, state), start, self.ground)
    }

    /// Minus twice the logarithm of the restricted likelihood of the voxels below the clipping value, and of the priors.
    fn unlikelihood(&self, state: &DVector<f64>, spread: &Spread) -> Option<f64> {
        let linear = self.linear(&self.unclipped, state);
        linear.scaled_unlikelihood(spread, &self.shares(&self.unclipped, state))
    }

    /// The voxels with the ball's share of each.
    fn shares(&self, samples: &[Sample], state: &DVector<f64>) -> Vec<VoxelShare> {
        let ball = ball(state, self.expected.blur.slice_mm);
        let (blur, metal) = (ball.blur(), ball.metal_hu());
        let one = |s: &Sample| {
            let d = s.place - ball.centre();
            let share = blur.value(d.x.hypot(d.y), d.z);
            VoxelShare {
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
        // The prior holds what the voxels do not tell, as the radius of a clipped ball.
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

    /// The minimum with the covariance that the state gives, and the inverse of the normal equations there.
    fn minimise_with_covariance_of(
        &self,
        start: &DVector<f64>,
        spread: &Spread,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let open = spread.factor(&self.shares(&self.unclipped, start))?;
        let mut samples = self.unclipped.clone();
        samples.extend(self.predicted_below_clip(start, spread, &open));
        let factor = match samples.len() == self.unclipped.len() {
            true => open,
            false => spread.factor(&self.shares(&samples, start))?,
        };
        self.minimise(&samples, start, &factor)
    }

    /// The clipped voxels for which less than the clipping value is predicted: as of that value.
    fn predicted_below_clip(&self, state: &DVector<f64>, spread: &Spread, open: &Cholesky<f64, Dyn>) -> Vec<Sample> {
        let weights = open.solve(&self.linear(&self.unclipped, state).residuals);
        let around = self.shares(&self.unclipped, state);
        let own = self.linear(&self.clipped, state);
        let predicted_less = |(i, at): (usize, &VoxelShare)| {
            let field: f64 = around
                .iter()
                .zip(weights.iter())
                .map(|(s, w)| spread.between(at, s) * w)
                .sum();
            // The residual is the data's minus the model's, and the data are the clipping value.
            own.residuals[i] - field > 0.0
        };
        let at = self.shares(&self.clipped, state);
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

    /// Where the steps end, and the inverse of the normal equations there.
    fn minimise(
        &self,
        samples: &[Sample],
        start: &DVector<f64>,
        factor: &Cholesky<f64, Dyn>,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let whitened = Whitened {
            refiner: self,
            samples,
            factor,
        };
        let end = least_squares(&whitened, start.clone(), DAMPING, Limits::tries(MAX_STEPS))?;
        // Without damping, which belongs to the way there and not to what is known.
        let inverse = end.at.0.cholesky()?.inverse();
        let is_converged = match end.end {
            End::Singular => false,
            // It may have been on its way yet.
            End::OutOfSteps => end.length < LAST_STEP_MM,
            End::Last | End::Flat | End::Settled | End::Nowhere => true,
        };
        is_converged.then_some((end.state, inverse))
    }
}

/// Voxels with the covariance of the field.
struct Whitened<'a> {
    refiner: &'a Refiner<'a>,
    samples: &'a [Sample],
    factor: &'a Cholesky<f64, Dyn>,
}

impl ::fit::Problem for Whitened<'_> {
    type State = DVector<f64>;
    type At = (DMatrix<f64>, DVector<f64>);

    fn look(&self, state: &DVector<f64>) -> Option<(f64, Self::At)> {
        let linear = self.refiner.linear(self.samples, state);
        let (matrix, vector, squares) = linear.normal(self.factor)?;
        Some((squares + linear.prior(), (matrix, vector)))
    }

    fn step(&self, state: &DVector<f64>, (matrix, vector): &Self::At, damping: f64) -> Option<Step<DVector<f64>>> {
        let mut damped = matrix.clone();
        (0..state.len()).for_each(|i| damped[(i, i)] *= 1.0 + damping);
        let step = damped.cholesky()?.solve(vector);
        Some(Step {
            to: state + &step,
            length: step.rows(0, 3).norm(),
            gain: step.dot(vector),
        })
    }

    fn is_settled(&self, made: &Made<'_, DVector<f64>, Self::At>) -> bool {
        made.length < STEP_END_MM
    }
}

/// Whether a voxel is not another piece of metal: beyond where the ball has faded nothing is as bright.
fn is_tissue(sample: &Sample, expected: &Expected) -> bool {
    let [plane, axial] = [expected.blur.plane_mm, expected.blur.profile_mm()];
    let end = |sigma: f64| MAX_RADIUS_RATIO * expected.blur.radius_mm + MAX_BLUR_RATIO * sigma;
    let d = sample.place;
    let within = (d.xy().norm() / end(plane)).powi(2) + (d.z / end(axial)).powi(2) <= 1.0;
    within || sample.hu - expected.ground_hu < OTHER_METAL_HU
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
