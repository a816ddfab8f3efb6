//! Shares, quantiles and their intervals.
//!
//! The targets of one operation share its calibration and its registration, so their errors are not independent. Intervals
//! here are therefore those of as many independent observations as there are operations: too wide rather than too narrow.

mod special;

use special::{beta, gamma};

/// Of all intervals: 95 of 100 hold what they are of.
pub const LEVEL: f64 = 0.95;
/// The 0.95 quantile of chi-squared with three degrees of freedom: the ellipsoid that holds 95 of 100 (Abramowitz and Stegun 1964,
/// table 26.8).
pub const CHI_SQUARE_95: f64 = 7.814_727_903_251_179;

/// A number with the interval that it is known to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// What was found.
    pub found: f64,
    /// From here to there, at [`LEVEL`].
    pub interval: [f64; 2],
}

/// The interval of a share of `n` observations, 0 to 1 (Clopper and Pearson, 1934): quantiles of beta distributions, which hold
/// for shares that are no whole number of observations too.
///
/// Not a number without observations.
pub fn share(found: f64, n: f64) -> Estimate {
    let (k, tail) = (found * n, 0.5 * (1.0 - LEVEL));
    let low = match k > 0.0 {
        true => beta_quantile(tail, k, n - k + 1.0),
        false => 0.0,
    };
    let high = match k < n {
        true => beta_quantile(1.0 - tail, k + 1.0, n - k),
        false => 1.0,
    };
    let interval = if n > 0.0 { [low, high] } else { [f64::NAN; 2] };
    Estimate { found, interval }
}

/// The `p` quantile of sorted numbers, the least that a share `p` of them does not exceed, with its interval for `n` independent
/// ones: from the `l`-th to the `u`-th of these by the binomial distribution of how many are below, which needs nothing of their own (order
/// statistics; David and Nagaraja 2003, 7.1). Of more numbers than `n` it goes by the parts `l / n` and `u / n`.
///
/// An end that `n` numbers do not bound is infinite: of the 0.95 quantile the upper one up to 71, of the median both up to 5. Not a number
/// without numbers.
pub fn quantile(sorted: &[f64], p: f64, n: f64) -> Estimate {
    let (count, tail) = (sorted.len() as f64, 0.5 * (1.0 - LEVEL));
    let ranked = |rank: f64| {
        let place = (rank.max(1.0) as usize).min(sorted.len());
        sorted.get(place.saturating_sub(1)).copied().unwrap_or(f64::NAN)
    };
    // That so many or more of them are below the quantile.
    let at_least = |k: f64| if k <= 0.0 { 1.0 } else { beta(p, k, n - k + 1.0) };
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let ranks = (1..=n.round() as usize).map(|k| k as f64);
    // The last of which fewer are below in so few cases, and the first with so many.
    if let Some(l) = ranks.clone().take_while(|l| 1.0 - at_least(*l) <= tail).last() {
        low = ranked(((l - 1.0) / n * count).floor() + 1.0);
    }
    if let Some(u) = ranks.clone().find(|u| at_least(*u) <= tail) {
        high = ranked((u / n * count).ceil());
    }
    Estimate {
        found: ranked((p * count).ceil()),
        interval: [low, high],
    }
}

/// Where the mean of `n` sums of three squares of normal numbers lies in 95 of 100 cases, were the deviations right: a third of
/// chi-squared of `3 n` degrees of freedom, times three.
pub fn nees_bounds(n: f64) -> [f64; 2] {
    let tail = 0.5 * (1.0 - LEVEL);
    [tail, 1.0 - tail].map(|p| chi_square_quantile(p, 3.0 * n) / n)
}

/// The root mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        (sum, count) = (sum + value * value, count + 1.0);
    }
    (sum / count).sqrt()
}

/// The mean.
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        (sum, count) = (sum + value, count + 1.0);
    }
    sum / count
}

/// The 0.975 quantile of Student's t with `k` degrees of freedom: `t^2 = k b / (1 - b)` with `b` that of a beta distribution of 1/2 and
/// k/2 (DLMF 8.17; `b` and `1 - b` by the smaller of both).
pub fn student(k: f64) -> f64 {
    let rest = beta_quantile(1.0 - LEVEL, 0.5 * k, 0.5);
    (k * (1.0 - rest) / rest).sqrt()
}

/// Numbers of one kind: how many, their mean and their variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// How many: at least two.
    pub count: f64,
    /// Their mean.
    pub mean: f64,
    /// Their variance, of one less than there are.
    pub variance: f64,
}

impl Sample {
    /// Of at least two numbers.
    pub fn of(values: &[f64]) -> Option<Self> {
        let (count, mean) = (values.len() as f64, mean(values.iter().copied()));
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        (count > 1.5).then(|| Self {
            count,
            mean,
            variance: squares / (count - 1.0),
        })
    }
}

/// A sum of means with weights, and its interval for samples of variances of their own (Welch 1947; degrees of freedom after
/// Satterthwaite 1946).
pub fn contrast(terms: &[(f64, Sample)]) -> Estimate {
    let (mut found, mut variance, mut fourth) = (0.0, 0.0, 0.0);
    for (weight, sample) in terms {
        let part = weight * weight * sample.variance / sample.count;
        found += weight * sample.mean;
        variance += part;
        fourth += part * part / (sample.count - 1.0);
    }
    let half = match variance > 0.0 {
        true => student(variance * variance / fourth) * variance.sqrt(),
        // Samples without any scatter, or none.
        false => variance,
    };
    Estimate {
        found,
        interval: [found - half, found + half],
    }
}

fn beta_quantile(p: f64, a: f64, b: f64) -> f64 {
    bisected([0.0, 1.0], |x| beta(x, a, b) < p)
}

fn chi_square_quantile(p: f64, k: f64) -> f64 {
    // Ten deviations beyond the mean and a constant for few degrees of freedom.
    let most = k + 10.0 * (2.0 * k).sqrt() + 50.0;
    bisected([0.0, most], |x| gamma(0.5 * x, 0.5 * k) < p)
}

/// Where a rising function passes what it is asked for, to the last bit or two.
fn bisected([mut low, mut high]: [f64; 2], is_below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        match is_below(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0 and 10 of 10: 1 - 0.025^(1/10); 5 of 10 and 19 of 20 of published tables (Clopper and Pearson 1934; Hahn and Meeker 1991).
    #[test]
    fn intervals_of_shares_are_those_of_the_tables() {
        let end = 1.0 - 0.025_f64.powf(0.1);
        let close = |found: [f64; 2], expected: [f64; 2], to: f64| {
            assert!(
                (0..2).all(|k| (found[k] - expected[k]).abs() < to),
                "{found:?} {expected:?}"
            );
        };
        close(share(0.0, 10.0).interval, [0.0, end], 1e-12);
        close(share(1.0, 10.0).interval, [1.0 - end, 1.0], 1e-12);
        close(share(0.5, 10.0).interval, [0.1871, 0.8129], 5e-5);
        close(share(0.95, 20.0).interval, [0.7513, 0.9987], 5e-5);
        assert!(share(0.5, 0.0).interval[0].is_nan());
    }

    /// By the definition: the binomial sum to either side at the ends is 0.025.
    #[test]
    fn the_ends_of_an_interval_leave_a_fortieth_to_each_side() {
        for (k, n) in [(1, 7), (93, 100), (30, 1000), (999, 1000)] {
            let [low, high] = share(f64::from(k) / f64::from(n), f64::from(n)).interval;
            let tail = |p: f64, from: i32, to: i32| -> f64 {
                let term = |i: i32| {
                    let ln = |m: i32| (1..=m).map(|x| f64::from(x).ln()).sum::<f64>();
                    (ln(n) - ln(i) - ln(n - i) + f64::from(i) * p.ln() + f64::from(n - i) * (1.0 - p).ln()).exp()
                };
                (from..=to).map(term).sum()
            };
            // Sums of a thousand logarithms: 1e-12 of each term.
            assert!((tail(low, k, n) - 0.025).abs() < 1e-9, "{k} {n} {low}");
            assert!((tail(high, 0, k) - 0.025).abs() < 1e-9, "{k} {n} {high}");
        }
    }

    /// Abramowitz and Stegun 1964, table 26.8: 30 degrees of freedom, 0.025 and 0.975; 3 degrees.
    #[test]
    fn chi_squared_is_that_of_the_table() {
        assert!((chi_square_quantile(0.975, 30.0) - 46.979_24).abs() < 1e-4);
        assert!((chi_square_quantile(0.025, 30.0) - 16.790_77).abs() < 1e-4);
        assert!((chi_square_quantile(0.95, 3.0) - CHI_SQUARE_95).abs() < 1e-9);
        let [low, high] = nees_bounds(10.0);
        assert!((low - 1.679_077).abs() < 1e-5 && (high - 4.697_924).abs() < 1e-5);
        // Many: the normal distribution's 3 -+ 1.96 sqrt(6 / n).
        let [low, high] = nees_bounds(1e4);
        assert!(
            (low - (3.0 - 1.96 * (6e-4_f64).sqrt())).abs() < 1e-3 && (high - 3.048).abs() < 1e-3,
            "{low} {high}"
        );
    }

    /// Abramowitz and Stegun 1964, table 26.10: 1, 4, 10 and 60 degrees of freedom, 0.975.
    #[test]
    fn students_t_is_that_of_the_table() {
        for (k, expected) in [(1.0, 12.706), (4.0, 2.776), (10.0, 2.228), (60.0, 2.000)] {
            assert!((student(k) - expected).abs() < 6e-4, "{k}: {}", student(k));
        }
    }

    /// One sample: Student's interval of a mean; two alike: their difference has twice the variance and twice the degrees of freedom.
    #[test]
    fn a_contrast_has_students_interval() {
        let sample = Sample::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert_eq!((sample.mean, sample.variance), (3.0, 2.5));
        let one = contrast(&[(1.0, sample)]);
        assert!((one.interval[1] - 3.0 - 2.776 * 0.5_f64.sqrt()).abs() < 1e-3, "{one:?}");
        let two = contrast(&[(1.0, sample), (-1.0, sample)]);
        assert!(two.found == 0.0 && (two.interval[1] - 2.306).abs() < 1e-3, "{two:?}");
        assert_eq!(Sample::of(&[1.0]), None);
    }

    #[test]
    fn quantiles_are_order_statistics() {
        let sorted: Vec<f64> = (1..=100).map(f64::from).collect();
        let median = quantile(&sorted, 0.5, 100.0);
        // Of 100 numbers the 40th and the 61st (binomial tables).
        assert_eq!((median.found, median.interval), (50.0, [40.0, 61.0]));
        assert_eq!(quantile(&sorted, 0.95, 100.0).found, 95.0);
        // Fewer independent ones, wider: the 6th and the 15th of 20.
        assert_eq!(quantile(&sorted, 0.5, 20.0).interval, [26.0, 75.0]);
        assert!(quantile(&[], 0.5, 0.0).found.is_nan());
    }

    /// One operation's error was given an interval from itself to itself, and of 20 the largest was the upper end of the 0.95 quantile, which
    /// holds it in 64 of 100 cases.
    #[test]
    fn an_end_that_so_few_numbers_do_not_bound_is_open() {
        let of = |n: usize, p: f64| {
            let sorted: Vec<f64> = (1..=n).map(|k| k as f64).collect();
            quantile(&sorted, p, n as f64).interval
        };
        let open = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!((of(1, 0.5), of(1, 0.95), of(5, 0.5)), (open, open, open));
        // 2 / 2^6 is 0.03; 0.95^72 is 0.0249 and 0.95^71 0.026.
        assert_eq!(of(6, 0.5), [1.0, 6.0]);
        assert_eq!(
            (of(20, 0.95)[1], of(71, 0.95)[1], of(72, 0.95)[1]),
            (open[1], open[1], 72.0)
        );
    }

    /// By the sum of the binomial distribution: no interval holds less than its level, whatever the number and the quantile.
    #[test]
    fn intervals_of_quantiles_hold_their_level() {
        for (n, p) in (1..=120).flat_map(|n| [0.5, 0.9, 0.95].map(|p| (n, p))) {
            let sorted: Vec<f64> = (1..=n).map(f64::from).collect();
            let [low, high] = quantile(&sorted, p, f64::from(n)).interval;
            let (mut one, mut holds) = ((1.0 - p).powi(n), 0.0);
            for k in 0..=n {
                // With k numbers below, the quantile lies between the k-th and the next.
                if low <= f64::from(k) && f64::from(k) < high {
                    holds += one;
                }
                one *= f64::from(n - k) / f64::from(k + 1) * p / (1.0 - p);
            }
            assert!(holds >= LEVEL - 1e-9, "{n} {p}: {low} to {high} hold {holds}");
        }
    }
}
