//! Weights that forget poses at which the shaft slipped, found without a start near the answer.
//!
//! As for a pivot ([`crate::pivot`]): first the criterion of Geman and McClure with a width so large that it is convex,
//! halved step by step (graduated non-convexity, Yang et al. 2020), then Tukey's biweight, `w = (1 - s^2 / 49)^2` below 7
//! deviations and nothing above, until the weights rest. The deviation follows from the median of the squares, so that no
//! noise has to be known; up to a half of the poses may be wrong. Residuals have two components each.

use super::Refused;

/// Median of chi-square with two degrees of freedom: 2 ln 2.
const MEDIAN_CHI2_2: f64 = 2.0 * std::f64::consts::LN_2;
/// Square of the constant of Geman and McClure, in deviations.
const GEMAN_MCCLURE_CHI2: f64 = 9.0;
/// Square of Tukey's constant, in deviations.
const TUKEY_CHI2: f64 = 49.0;
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

/// Tukey's weight of a square.
fn biweight(square: f64) -> f64 {
    (1.0 - square / TUKEY_CHI2).max(0.0).powi(2)
}

/// `w + s^2 dw / d(s^2)`: the mean slope of `w r` over the two components.
fn slope(square: f64) -> f64 {
    let left = (1.0 - square / TUKEY_CHI2).max(0.0);
    left * left - 2.0 * left * square / TUKEY_CHI2
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
    // As for a pivot: convex at first, and at most twenty halvings.
    let mut mu = (2.0 * largest / GEMAN_MCCLURE_CHI2).min(1e6);
    while mu > 1.0 {
        run.advance(|square| (mu * GEMAN_MCCLURE_CHI2 / (mu * GEMAN_MCCLURE_CHI2 + square)).powi(2))?;
        mu *= 0.5;
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
        let n = self.weights.len();
        for (i, square) in self.squares.iter_mut().enumerate() {
            *square = self.problem.square(&self.found, i);
        }
        let mut sorted = self.squares.clone();
        let (_, median, _) = sorted.select_nth_unstable_by(n / 2, f64::total_cmp);
        let freedom = n as f64 / (n as f64 - 2.0);
        let squared = (*median / MEDIAN_CHI2_2 * freedom)
            .max(self.problem.rounding())
            .max(f64::MIN_POSITIVE);
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
        let turn = mean(&slope);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_the_derivative_of_the_weighted_residual() {
        for s in [0.0, 0.5, 2.0, 4.0, 6.9, 7.1, 20.0_f64] {
            // d(w r) / dr along r, and w across it.
            let h = 1e-6;
            let pull = |s: f64| biweight(s * s) * s;
            let along = (pull(s + h) - pull(s - h)) / (2.0 * h);
            let mean = (along + biweight(s * s)) / 2.0;
            assert!((mean - slope(s * s)).abs() < 1e-8, "{s}: {mean} {}", slope(s * s));
        }
    }
}
