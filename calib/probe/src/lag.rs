//! How late images are behind poses, from one motion that both show.
//!
//! The probe is moved back and forth over something flat; a number that is read off each image (the row of a line)
//! follows the probe's way
//! along one direction. With `i` that number and `p` the way,
//!
//! ```text
//! i(t) = a + b p(t + lag) + noise                                                                               (1)
//! ```
//!
//! For each lag the best `a` and `b` are linear; the lag is where the sum of squares is least. So **the pose that
//! goes with an image of time
//! t is that of time t + lag**: above 0 where poses come with later stamps than images do.
//!
//! The way is read as a mean over a window: between two samples that are read as they are the noise is less midway,
//! which would draw the
//! lag there. The window lowers fast motions, not their time: what that leaves is at right angles to what a lag does.

mod doubt;
mod error;
mod signal;

pub use error::LagError;
pub use signal::principal_motion;

use nalgebra::{Matrix2, Vector2};

use signal::Smooth;

/// A lag from motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionLag {
    /// s: the pose that goes with an image of time t is that of time t + this.
    pub lag_s: f64,
    /// Its standard deviation, s, residuals being correlated as they are.
    pub sigma_s: f64,
    /// `b`: units of the image's number a unit of the way; too large by what the window lowers of the motion.
    pub gain: f64,
    /// Correlation of both signals at this lag, 0 to 1.
    pub correlation: f64,
    /// Root mean square residual, in units of the image's number.
    pub residual: f64,
    /// Samples that were used, and such as were left out as gross errors.
    pub samples: [usize; 2],
}

/// How a lag is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LagOptions {
    /// The largest lag, s, either way.
    pub most_s: f64,
    /// Deviation of the window that the way is a mean over, s; at least the time between two poses.
    pub window_s: f64,
    /// The least correlation.
    pub min_correlation: f64,
    /// The largest deviation of the lag, s.
    pub max_sigma_s: f64,
}

impl Default for LagOptions {
    fn default() -> Self {
        Self {
            most_s: 0.5,
            window_s: 0.1,
            min_correlation: 0.9,
            max_sigma_s: 0.02,
        }
    }
}

/// The fewest samples of either signal.
const LEAST: usize = 20;
/// Steps of the coarse search to each side.
const STEPS: usize = 100;
/// A residual beyond so many deviations is a gross error.
const GROSS: f64 = 4.0;
/// Depths of minima as shares of what there is to explain: a tenth of it is more than noise makes.
const DEPTH: f64 = 0.1;
/// Rounds of letting go, at most.
const ROUNDS: usize = 6;
/// Values beyond so many deviations, by the median's distance, are drawn in at first: a swing reaches 2.1 of them.
const FAR: f64 = 3.0;
/// Median of the absolute value of a normal residual.
const MEDIAN_ABS: f64 = 0.674_489_750_196_081_7;

/// Finds the lag of poses behind images; each signal is (time, s; value), the image's any number that is linear in
/// the way.
///
/// # Errors
/// [`LagError`]: also where the motion says nothing of it.
pub fn lag(image: &[(f64, f64)], way: &[(f64, f64)], options: &LagOptions) -> Result<MotionLag, LagError> {
    options.check()?;
    signal::checked("image", image)?;
    let way = Smooth::new("pose", way, options.window_s)?;
    let mut fit = Fit::new(image, &way, options)?;
    let mut found = fit.least()?;
    // What lies far off the line is let go of, and the search begins anew.
    for _ in 0..ROUNDS {
        if !fit.let_go(image, found)? {
            break;
        }
        found = fit.least()?;
    }
    fit.result(found)
}

impl LagOptions {
    fn check(&self) -> Result<(), LagError> {
        let rows = [
            ("the largest lag, s", self.most_s, 0.01..=5.0),
            ("the window, s", self.window_s, 0.001..=1.0),
            ("the least correlation", self.min_correlation, 0.1..=1.0),
            ("the largest deviation of the lag, s", self.max_sigma_s, 1e-5..=1.0),
        ];
        // A NaN is within nothing.
        match rows.into_iter().find(|(_, found, range)| !range.contains(found)) {
            None => Ok(()),
            Some((what, found, range)) => Err(LagError::Option {
                what,
                found,
                least: *range.start(),
                most: *range.end(),
            }),
        }
    }
}

/// Both signals, and which samples of the image count.
struct Fit<'a> {
    way: &'a Smooth,
    options: LagOptions,
    /// Time and value of the image's samples.
    samples: Vec<(f64, f64)>,
    gross: usize,
}

/// The best line at a lag.
#[derive(Clone, Copy)]
struct Line {
    offset: f64,
    gain: f64,
    squares: f64,
}

impl<'a> Fit<'a> {
    fn new(image: &[(f64, f64)], way: &'a Smooth, options: &LagOptions) -> Result<Self, LagError> {
        let mut fit = Self {
            way,
            options: *options,
            samples: Vec::new(),
            gross: 0,
        };
        let inside = fit.inside(image);
        let middle = fit::median(inside.iter().map(|s| s.1).collect());
        let spread = fit::median(inside.iter().map(|s| (s.1 - middle).abs()).collect()) / MEDIAN_ABS;
        // Gross errors would hide the motion from the first search; after it they are told by their distance from
        // the line.
        let drawn_in = |v: f64| v.clamp(middle - FAR * spread, middle + FAR * spread);
        fit.samples = inside.into_iter().map(|(t, v)| (t, drawn_in(v))).collect();
        fit.enough()?;
        Ok(fit)
    }

    /// At every lag that is tried the same samples have a pose: sums over different ones could not be compared.
    fn inside(&self, image: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let (first, last) = self.way.span();
        let (first, last) = (first + self.options.most_s, last - self.options.most_s);
        image
            .iter()
            .copied()
            .filter(|(t, _)| (first..=last).contains(t))
            .collect()
    }

    fn enough(&self) -> Result<(), LagError> {
        match self.samples.len() < LEAST {
            false => Ok(()),
            true => Err(LagError::Overlap {
                found: self.samples.len(),
                needed: LEAST,
                most_s: self.options.most_s,
            }),
        }
    }

    fn line(&self, lag: f64) -> Line {
        let (mut normal, mut right, mut total) = (Matrix2::<f64>::zeros(), Vector2::<f64>::zeros(), 0.0);
        let middle = self.way.mean();
        for (t, value) in &self.samples {
            let basis = Vector2::new(1.0, self.way.at(t + lag).0 - middle);
            normal += basis * basis.transpose();
            right += basis * *value;
            total += value * value;
        }
        let solved = normal
            .try_inverse()
            .map_or_else(Vector2::zeros, |inverse| inverse * right);
        Line {
            offset: solved.x - solved.y * middle,
            gain: solved.y,
            squares: (total - solved.dot(&right)).max(0.0),
        }
    }

    /// The lag of the least sum of squares.
    fn least(&self) -> Result<f64, LagError> {
        let step = self.options.most_s / STEPS as f64;
        let at = |k: usize| (k as f64 - STEPS as f64) * step;
        let sums: Vec<f64> = (0..=2 * STEPS).map(|k| self.line(at(k)).squares).collect();
        let best = (0..sums.len())
            .min_by(|a, b| sums[*a].total_cmp(&sums[*b]))
            .unwrap_or(STEPS);
        let total = self.spread() * self.samples.len() as f64;
        let most = sums.iter().fold(0.0, |a: f64, b| a.max(*b));
        if most - sums[best] < DEPTH * total {
            return Err(self.flat(at(best), sums[best], total));
        }
        if best == 0 || best == 2 * STEPS {
            return Err(LagError::Edge {
                most_s: self.options.most_s,
            });
        }
        self.distinct(&sums, best, &at)?;
        Ok(self.golden(at(best - 1), at(best + 1)))
    }

    /// No lag is better than another: nothing moves, or all at one speed, where a lag is but another offset.
    fn flat(&self, lag_s: f64, squares: f64, total: f64) -> LagError {
        let correlation = (1.0 - squares / total.max(f64::MIN_POSITIVE)).max(0.0).sqrt();
        match correlation < self.options.min_correlation {
            true => LagError::Unlike {
                correlation,
                least: self.options.min_correlation,
            },
            false => LagError::Blunt {
                lag_s,
                sigma_s: f64::INFINITY,
                most_s: self.options.max_sigma_s,
            },
        }
    }

    /// Refuses another minimum that is nearly as deep, with worse between: a motion that repeats itself.
    fn distinct(&self, sums: &[f64], best: usize, at: &impl Fn(usize) -> f64) -> Result<(), LagError> {
        let is_least = |k: usize| sums[k] < sums[k - 1] && sums[k] <= sums[k + 1];
        let total = self.spread() * self.samples.len() as f64;
        let others = (1..sums.len() - 1).filter(|k| *k != best && is_least(*k));
        let barrier = |k: usize| sums[k.min(best)..=k.max(best)].iter().fold(0.0, |a: f64, b| a.max(*b));
        let near = others
            .filter(|k| sums[*k] - sums[best] < DEPTH * total)
            .filter(|k| barrier(*k) - sums[*k] > DEPTH * total);
        match near.min_by(|a, b| sums[*a].total_cmp(&sums[*b])) {
            None => Ok(()),
            Some(other) => Err(LagError::Ambiguous {
                lag_s: at(best),
                other_s: at(other),
            }),
        }
    }

    /// Variance of the image's samples.
    fn spread(&self) -> f64 {
        let n = self.samples.len() as f64;
        let mean = self.samples.iter().map(|s| s.1).sum::<f64>() / n;
        self.samples.iter().map(|s| (s.1 - mean).powi(2)).sum::<f64>() / n
    }

    /// The least between two lags on either side of it, by the golden section, to 1e-7 s.
    fn golden(&self, mut low: f64, mut high: f64) -> f64 {
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        while high - low > 1e-7 {
            let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
            if self.line(a).squares < self.line(b).squares {
                high = b;
            } else {
                low = a;
            }
        }
        0.5 * (low + high)
    }

    /// Keeps the samples that lie near the line; whether those are others than before.
    fn let_go(&mut self, image: &[(f64, f64)], lag: f64) -> Result<bool, LagError> {
        let line = self.line(lag);
        let all = self.inside(image);
        let residual = |(t, v): &(f64, f64)| (v - line.offset - line.gain * self.way.at(t + lag).0).abs();
        let sigma = fit::median(all.iter().map(residual).collect()) / MEDIAN_ABS;
        let kept: Vec<(f64, f64)> = all.iter().copied().filter(|s| residual(s) <= GROSS * sigma).collect();
        let is_new = kept != self.samples;
        (self.gross, self.samples) = (all.len() - kept.len(), kept);
        self.enough()?;
        Ok(is_new)
    }

    fn result(&self, lag_s: f64) -> Result<MotionLag, LagError> {
        let line = self.line(lag_s);
        let n = self.samples.len();
        let total = self.spread() * n as f64;
        let correlation = (1.0 - line.squares / total.max(f64::MIN_POSITIVE)).max(0.0).sqrt();
        if correlation.is_nan() || correlation < self.options.min_correlation {
            return Err(LagError::Unlike {
                correlation,
                least: self.options.min_correlation,
            });
        }
        self.not_beyond(lag_s)?;
        let sigma_s = self.steady(lag_s, self.sigma(lag_s, &line))?;
        if sigma_s.is_nan() || sigma_s > self.options.max_sigma_s {
            return Err(LagError::Blunt {
                lag_s,
                sigma_s,
                most_s: self.options.max_sigma_s,
            });
        }
        Ok(MotionLag {
            lag_s,
            sigma_s,
            gain: line.gain,
            correlation,
            residual: (line.squares / (n as f64 - 3.0)).sqrt(),
            samples: [n, self.gross],
        })
    }

    /// The deviation from the curvature and from the pulls: their squares, or where that is more the sum of the
    /// products of neighbours'
    /// (Newey and West 1987) over as many as the window reaches; with few products that sum alone is too small now
    /// and then.
    fn sigma(&self, lag_s: f64, line: &Line) -> f64 {
        let n = self.samples.len();
        let points: Vec<(f64, f64)> = self.samples.iter().map(|(t, _)| self.way.at(t + lag_s)).collect();
        // What a change of the lag does beyond what offset and gain can take up.
        let speeds = beyond(&points);
        let pulls: Vec<f64> = self
            .samples
            .iter()
            .zip(&points)
            .zip(&speeds)
            .map(|(((_, value), (place, _)), speed)| (value - line.offset - line.gain * place) * line.gain * speed)
            .collect();
        let curvature: f64 = speeds.iter().map(|s| (line.gain * s).powi(2)).sum();
        let span = self.samples[n - 1].0 - self.samples[0].0;
        let step = span / (n as f64 - 1.0);
        let reach = ((6.0 * self.options.window_s / step).ceil() as usize)
            .max((n as f64).cbrt() as usize)
            .min(n / 3);
        let squares: f64 = pulls.iter().map(|p| p * p).sum();
        let mut sum = squares;
        for k in 1..=reach {
            let weight = 1.0 - k as f64 / (reach as f64 + 1.0);
            sum += 2.0 * weight * pulls.windows(k + 1).map(|w| w[0] * w[k]).sum::<f64>();
        }
        // Three numbers were fitted.
        let few = n as f64 / (n as f64 - 3.0);
        (sum.max(squares) * few).sqrt() / curvature
    }
}

/// The speeds less their parts along 1 and the places.
fn beyond(points: &[(f64, f64)]) -> Vec<f64> {
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (place, speed) = (mean(&|p| p.0), mean(&|p| p.1));
    let (mut both, mut square) = (0.0, 0.0);
    for (p, s) in points {
        both += (p - place) * (s - speed);
        square += (p - place) * (p - place);
    }
    let slope = if square > 0.0 { both / square } else { 0.0 };
    points.iter().map(|(p, s)| s - speed - slope * (p - place)).collect()
}
