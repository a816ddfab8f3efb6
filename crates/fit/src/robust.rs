//! Weights that forget gross errors, found without a start near the answer.
//!
//! `square` is that of a residual in deviations: chi-square with as many degrees of freedom as a residual has components. The criterion
//! is first that of Geman and McClure, `mu c^2 s^2 / (mu c^2 + s^2)`, with `mu` so large that it is convex, then halved down to 1
//! (graduated non-convexity, Yang et al. 2020), at the end Tukey's biweight, `w = (1 - s^2 / 49)^2` below 7 deviations and nothing
//! above. The scale follows from the median of the squares, so that only the ratios of the noises have to be known; up to a half of
//! the residuals may be wrong.

/// Square of the constant of Geman and McClure, in deviations.
const GEMAN_MCCLURE_CHI2: f64 = 9.0;
/// Square of Tukey's constant, in deviations: 7. With three components of normal noise the variance is 1.019 times the least.
pub const TUKEY_CHI2: f64 = 49.0;
/// Median of chi-square with two degrees of freedom: 2 ln 2.
pub const MEDIAN_CHI2_2: f64 = 2.0 * std::f64::consts::LN_2;
/// Median of chi-square with three degrees of freedom.
pub const MEDIAN_CHI2_3: f64 = 2.365_973_884_375_338;

/// The widths `mu` of the convex phase, for residuals whose largest square is `largest`.
///
/// Geman and McClure's criterion is convex up to `s^2 = mu c^2 / 3`; Yang et al. begin at `mu = 2 s^2 / c^2`. At most twenty
/// halvings, however far a residual is off.
pub fn convex_widths(largest: f64) -> impl Iterator<Item = f64> {
    let first = (2.0 * largest / GEMAN_MCCLURE_CHI2).min(1e6);
    std::iter::successors(Some(first), |mu| Some(mu * 0.5)).take_while(|mu| *mu > 1.0)
}

/// The weight of a square by Geman and McClure's criterion of width `mu`.
pub fn geman_mcclure(mu: f64, square: f64) -> f64 {
    (mu * GEMAN_MCCLURE_CHI2 / (mu * GEMAN_MCCLURE_CHI2 + square)).powi(2)
}

/// Tukey's weight of a square.
pub fn biweight(square: f64) -> f64 {
    (1.0 - square / TUKEY_CHI2).max(0.0).powi(2)
}

/// The mean slope of `w r` over the components of a residual, `w + (2 / k) s^2 dw / d(s^2)` for `k` of them.
pub fn biweight_slope(square: f64, components: f64) -> f64 {
    let left = (1.0 - square / TUKEY_CHI2).max(0.0);
    left * left - 4.0 / components * left * square / TUKEY_CHI2
}

/// The square of the residuals' scale, by the median of their squares over the median of chi-square; at least `least`.
///
/// The order of `squares` is lost. Two residuals' worth of components are taken as fitted, whence
/// `n / (n - 2)`.
pub fn squared_scale(squares: &mut [f64], median_chi2: f64, least: f64) -> f64 {
    let n = squares.len();
    if n == 0 {
        return least.max(f64::MIN_POSITIVE);
    }
    // Fewer than half of the residuals may be wrong by any amount without moving the median beyond the good ones.
    let (_, median, _) = squares.select_nth_unstable_by(n / 2, f64::total_cmp);
    // The residuals of a fit are shorter than their errors: two of n were fitted.
    let freedom = n as f64 / (n as f64 - 2.0);
    (*median / median_chi2 * freedom)
        .max(least)
        // Perfect data, and a bound that has underflowed: zero over zero is kept out.
        .max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_the_derivative_of_the_weighted_residual() {
        for components in [2.0, 3.0] {
            for s in [0.0, 0.5, 2.0, 4.0, 6.9, 7.1, 20.0_f64] {
                // d(w r) / dr along r, and w across it for all other components.
                let h = 1e-6;
                let pull = |s: f64| biweight(s * s) * s;
                let along = (pull(s + h) - pull(s - h)) / (2.0 * h);
                let mean = (along + (components - 1.0) * biweight(s * s)) / components;
                let slope = biweight_slope(s * s, components);
                assert!((mean - slope).abs() < 1e-8, "{s}: {mean} {slope}");
            }
        }
    }

    #[test]
    fn widths_are_halved_until_the_criterion_is_its_own() {
        assert_eq!(convex_widths(36.0).collect::<Vec<_>>(), [8.0, 4.0, 2.0]);
        assert_eq!((convex_widths(4.5).count(), convex_widths(f64::MAX).count()), (0, 20));
        assert_eq!(convex_widths(f64::NAN).count(), 20);
        assert_eq!(geman_mcclure(2.0, 18.0), 0.25);
    }

    #[test]
    fn the_scale_of_half_wrong_residuals_is_that_of_the_good_half() {
        // 51 good ones whose median is that of chi-square, scaled by 4, and 48 that are off by anything.
        let good = (0..51).map(|i| 4.0 * MEDIAN_CHI2_3 * (1.0 + (f64::from(i) - 49.0) * 1e-3));
        let mut all: Vec<f64> = good.chain((0..48).map(|i| 1e6 + f64::from(i))).collect();
        // The median is the 50th of 99.
        assert!((squared_scale(&mut all, MEDIAN_CHI2_3, 0.0) - 4.0 * 99.0 / 97.0).abs() < 1e-12);
        assert_eq!(squared_scale(&mut [0.0; 9], MEDIAN_CHI2_2, 0.25), 0.25);
        assert_eq!(squared_scale(&mut [], MEDIAN_CHI2_2, 0.25), 0.25);
    }
}
