//! Weights that forget poses which slipped, found without a start near the answer.
//!
//! The weights are those of [`fit::robust`] for `s^2 = r'^T S^-1 r' / scale^2`, which has three components: one weighted step for each
//! width of the convex criterion, then Tukey's biweight until nothing moves.

use fit::robust::{MEDIAN_CHI2_3, TUKEY_CHI2, biweight, convex_widths, geman_mcclure, squared_scale};
use nalgebra::Vector6;

use super::Refused;
use super::linear::{Problem, State};
use super::noise::PoseNoise;
use super::step::{self, Normal, moved};

/// Steps of each phase; five are usual at the end.
const MAX_STEPS: usize = 200;
/// A step whose square, in deviations of the result, is below this ends the iteration.
const STEP_END: f64 = 1e-10;
/// Relative rounding of residuals: below it they say nothing.
const RESIDUAL_ROUNDING: f64 = 1e-13;

/// What is known of the poses' noise, of which only the ratios count.
pub(super) trait Noise {
    /// The size of the translations' noise, mm.
    fn sigma_mm(&self) -> f64;
    /// The normal equations at `state`, each pose with the weight given.
    fn normal(&self, problem: &Problem, state: &State, weights: &[f64]) -> Normal;
    /// `r'^T S^-1 r'` of every pose into `squares`: chi-square of 3 where the noise is right.
    fn squares(&self, problem: &Problem, state: &State, squares: &mut [f64]);
}

/// The answer and what it left.
pub(super) struct Settled {
    pub(super) state: State,
    /// In units of the scale: `s^2` of every pose.
    pub(super) squares: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// The scale of the noise found, in units of the noise given.
    pub(super) scale: f64,
    /// The equations became singular: the poses that agree do not determine a tip. Their weights are 1, the others' 0.
    pub(super) singular: bool,
}

/// Runs both phases from `start`.
pub(super) fn settle<N: Noise>(problem: &Problem, start: State, noise: &N) -> Result<Settled, Refused> {
    let n = problem.poses.len();
    let mut run = Run {
        problem,
        noise,
        floor: floor(problem, &start, noise),
        settled: Settled {
            state: start,
            squares: vec![0.0; n],
            weights: vec![1.0; n],
            scale: 1.0,
            singular: false,
        },
        sorted: vec![0.0; n],
    };
    run.measure();
    let largest = run.settled.squares.iter().copied().fold(0.0, f64::max);
    // Convex at first, so that a start that slipped poses have spoilt is left behind.
    for mu in convex_widths(largest) {
        run.reweigh(|square| geman_mcclure(mu, square));
        if run.advance().is_none() {
            return Ok(run.stuck());
        }
    }
    if !run.finish()? {
        return Ok(run.stuck());
    }
    Ok(run.settled)
}

/// Scale below which residuals are rounding: `scale^2`.
fn floor<N: Noise>(problem: &Problem, start: &State, noise: &N) -> f64 {
    let size = problem.centre.norm() + start.tip.norm() + start.pivot.norm();
    (RESIDUAL_ROUNDING * size / noise.sigma_mm()).powi(2)
}

struct Run<'a, N: Noise> {
    problem: &'a Problem,
    noise: &'a N,
    floor: f64,
    settled: Settled,
    sorted: Vec<f64>,
}

impl<N: Noise> Run<'_, N> {
    /// Squares and scale at the present state.
    fn measure(&mut self) {
        let Settled {
            state,
            squares: list,
            scale,
            ..
        } = &mut self.settled;
        self.noise.squares(self.problem, state, list);
        self.sorted.copy_from_slice(list);
        // Six of 3 n components were fitted, two residuals' worth.
        let squared = squared_scale(&mut self.sorted, MEDIAN_CHI2_3, self.floor);
        *scale = squared.sqrt();
        list.iter_mut().for_each(|s| *s /= squared);
    }

    fn reweigh(&mut self, weight: impl Fn(f64) -> f64) {
        let both = self.settled.weights.iter_mut().zip(&self.settled.squares);
        both.for_each(|(w, s)| *w = weight(*s));
    }

    /// One weighted step; its square in deviations of the result, and its length, mm. `None` where singular.
    fn advance(&mut self) -> Option<(f64, f64)> {
        let normal = self
            .noise
            .normal(self.problem, &self.settled.state, &self.settled.weights);
        let step: Vector6<f64> = normal.step()?;
        self.settled.state = moved(&self.settled.state, &step);
        // The normal matrix is the inverse covariance by the noise given; over scale^2 it is that by the noise found.
        let square = step.dot(&(normal.matrix * step)) / self.settled.scale.powi(2);
        self.measure();
        Some((square, step.norm()))
    }

    /// What is known where the equations became singular: which poses agree.
    fn stuck(mut self) -> Settled {
        // Those that Tukey's weight would keep, so that the coverage of these can be told.
        self.reweigh(|square| f64::from(u8::from(square < TUKEY_CHI2)));
        self.settled.singular = true;
        self.settled
    }

    /// Tukey's weights until nothing moves; false where singular.
    fn finish(&mut self) -> Result<bool, Refused> {
        let mut last_mm = f64::INFINITY;
        let size = self.settled.state.tip.norm() + self.settled.state.pivot.norm() + self.problem.centre.norm();
        for _ in 0..MAX_STEPS {
            self.reweigh(biweight);
            let Some((square, length)) = self.advance() else {
                return Ok(false);
            };
            last_mm = length;
            // Of perfect data the scale is rounding, and steps of rounding are as large as deviations: then their
            // length decides.
            if square < STEP_END || length < 100.0 * RESIDUAL_ROUNDING * size {
                self.reweigh(biweight);
                return Ok(true);
            }
        }
        let steps = MAX_STEPS;
        Err(Refused::NoConvergence { steps, last_mm })
    }
}

impl Noise for PoseNoise {
    fn sigma_mm(&self) -> f64 {
        self.sigma_mm
    }

    fn normal(&self, problem: &Problem, state: &State, weights: &[f64]) -> Normal {
        Normal::new(problem, state, self, weights)
    }

    fn squares(&self, problem: &Problem, state: &State, squares: &mut [f64]) {
        step::squares(problem, state, self, squares);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fit::robust::biweight_slope;

    #[test]
    fn the_documented_efficiency_is_the_one_of_three_components() {
        // Chi with three degrees of freedom: density sqrt(2 / pi) s^2 exp(-s^2 / 2), by the midpoint rule.
        let (mut pull, mut turn, mut all) = (0.0, 0.0, 0.0);
        for i in 0..100_000 {
            let s = (i as f64 + 0.5) * 1e-4;
            let density = s * s * (-0.5 * s * s).exp();
            all += density;
            pull += density * (biweight(s * s) * s).powi(2) / 3.0;
            turn += density * biweight_slope(s * s, 3.0);
        }
        let variance = pull / all / (turn / all).powi(2);
        assert!((variance - 1.019).abs() < 5e-4, "{variance}");
    }
}
