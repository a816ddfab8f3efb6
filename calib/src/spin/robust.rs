//! Weights that forget poses at which the shaft slipped, found without a start near the answer.
//!
//! The weights are those of [`fit::robust`], until they rest; residuals have two components each, and no noise has to be known.

use fit::robust::{MEDIAN_CHI2_2, biweight, biweight_slope, convex_widths, geman_mcclure, squared_scale};

use super::Refused;

/// Steps of the last phase; ten are usual.
const MAX_STEPS: usize = 500;
/// A largest change of a weight below this ends it.
const LAST_WEIGHT_CHANGE: f64 = 1e-6;
/// With fewer poses a median of residuals says nothing, and all count.
const MIN_POSES: usize = 8;

/// A linear least squares problem.
pub(super) trait Fit {
    /// The solution.
    type Found;
    /// How many residuals of two components there are.
    fn count(&self) -> usize;
    /// The solution for weights.
    fn fit(&self, weights: &[f64]) -> Option<Self::Found>;
    /// The squared length of residual `i`.
    fn square(&self, found: &Self::Found, i: usize) -> f64;
    /// The square of a residual that is rounding.
    fn rounding(&self) -> f64;
}

/// A solution with its weights.
pub(super) struct Settled<T> {
    pub(super) found: T,
    pub(super) weights: Vec<f64>,
    /// The variance of a component of a solution whose equations have the inliers with weight 1.
    pub(super) variance: f64,
}

/// Solves, with weights where `robust` and there are poses enough.
pub(super) fn settle<F: Fit>(problem: &F, robust: bool) -> Result<Settled<F::Found>, Refused> {
    let count = problem.count();
    let mut run = Run::new(problem, vec![1.0; count])?;
    // Least squares: the mean square of a component is the variance, and the slope of `w r` is 1.
    if !robust || count < MIN_POSES {
        let pull = run.squares.iter().sum::<f64>() / count as f64 / 2.0;
        return Ok(run.settled(pull, 1.0));
    }
    let largest = run.squares.iter().copied().fold(0.0, f64::max);
    // Convex at first, so that a start that slipped poses have spoilt is left behind.
    for mu in convex_widths(largest) {
        run.advance(|square| geman_mcclure(mu, square))?;
    }
    for _ in 0..MAX_STEPS {
        if run.advance(biweight)? <= LAST_WEIGHT_CHANGE {
            return run.judged();
        }
    }
    Err(Refused::NoConvergence { steps: MAX_STEPS })
}

struct Run<'a, F: Fit> {
    problem: &'a F,
    found: F::Found,
    weights: Vec<f64>,
    /// In units of `scale^2`.
    squares: Vec<f64>,
    scale: f64,
}

impl<'a, F: Fit> Run<'a, F> {
    fn new(problem: &'a F, weights: Vec<f64>) -> Result<Self, Refused> {
        let found = problem.fit(&weights).ok_or(Refused::NoFrame)?;
        let mut run = Self {
            problem,
            found,
            squares: vec![0.0; weights.len()],
            weights,
            scale: 1.0,
        };
        run.measure();
        Ok(run)
    }

    fn measure(&mut self) {
        for (i, square) in self.squares.iter_mut().enumerate() {
            *square = self.problem.square(&self.found, i);
        }
        let squared = squared_scale(&mut self.squares.clone(), MEDIAN_CHI2_2, self.problem.rounding());
        self.scale = squared.sqrt();
        self.squares.iter_mut().for_each(|s| *s /= squared);
    }

    /// One weighted solution; the largest change of a weight.
    fn advance(&mut self, weight: impl Fn(f64) -> f64) -> Result<f64, Refused> {
        let next: Vec<f64> = self.squares.iter().map(|s| weight(*s)).collect();
        // Each step solves a linear problem in full, so that only the weights can move.
        let change = next.iter().zip(&self.weights).map(|(a, b)| (a - b).abs());
        let change = change.fold(0.0, f64::max);
        self.weights = next;
        let poses = self.weights.len();
        let found = self.weights.iter().filter(|w| **w > 0.0).count();
        let needed = super::MIN_POSES.max(poses / 2 + 1);
        let none = Refused::NoConsensus { found, poses, needed };
        self.found = self.problem.fit(&self.weights).ok_or(none)?;
        self.measure();
        Ok(change)
    }

    /// Refuses where less than a half agree. The variance is that of the M-estimator (Huber 1981, chapter 6).
    fn judged(self) -> Result<Settled<F::Found>, Refused> {
        let inside = || self.squares.iter().zip(&self.weights).filter(|(_, w)| **w > 0.0);
        let (found, poses) = (inside().count(), self.weights.len());
        // A majority: the scale is that of the better half, and any half agrees with itself.
        let needed = super::MIN_POSES.max(poses / 2 + 1);
        if found < needed {
            return Err(Refused::NoConsensus { found, poses, needed });
        }
        let mean = |of: &dyn Fn(f64) -> f64| inside().map(|(s, _)| of(*s)).sum::<f64>() / found as f64;
        let pull = mean(&|s| biweight(s).powi(2) * s / 2.0);
        let turn = mean(&|s| biweight_slope(s, 2.0));
        Ok(self.settled(pull, turn))
    }

    fn settled(self, pull: f64, turn: f64) -> Settled<F::Found> {
        let n = self.weights.iter().filter(|w| **w > 0.0).count() as f64;
        // Two components a pose; four numbers were fitted, to directions and to places alike.
        let freedom = n / (n - 2.0);
        Settled {
            variance: self.scale.powi(2) * freedom * pull / (turn * turn),
            found: self.found,
            weights: self.weights,
        }
    }
}
