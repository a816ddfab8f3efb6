//! The normal distribution.

/// `1 / sqrt(2 pi)`.
const DENSITY: f64 = 0.398_942_280_401_432_7;

/// Density of the standard normal distribution.
pub(crate) fn density(x: f64) -> f64 {
    DENSITY * (-0.5 * x * x).exp()
}

/// Its distribution, to 7.5e-8 (Abramowitz and Stegun 1964, 26.2.17): of a step of 3000 HU that is 0.0003 HU.
pub(crate) fn distribution(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let sum =
        t * (0.319_381_530 + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let upper = density(x) * sum;
    if x > 0.0 { 1.0 - upper } else { upper }
}

/// A step blurred by a kernel of deviation 1 that is nearly the normal distribution, to the first term of Edgeworth's series in its excess
/// kurtosis: a box of voxels has less than the normal distribution, by 1.2 times its share of the variance squared.
pub(crate) fn step(x: f64, kurtosis: f64) -> f64 {
    distribution(x) - kurtosis / 24.0 * by_kurtosis(x)
}

/// Its derivative by x.
pub(crate) fn slope(x: f64, kurtosis: f64) -> f64 {
    density(x) * (1.0 + kurtosis / 24.0 * (x.powi(4) - 6.0 * x * x + 3.0))
}

/// The third Hermite polynomial times the density: of it, a 24th is what a step loses by kurtosis.
pub(crate) fn by_kurtosis(x: f64) -> f64 {
    (x * x * x - 3.0 * x) * density(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_tables() {
        for (x, value) in [
            (0.0, 0.5),
            (1.0, 0.841_344_746),
            (-1.96, 0.024_997_895),
            (5.0, 0.999_999_713),
        ] {
            assert!((distribution(x) - value).abs() < 7.5e-8 + 1e-9, "{x}");
        }
    }

    /// A box of the full variance has the kurtosis -1.2; mixed with a Gaussian it is told to a few thousandths by the series.
    #[test]
    fn a_box_with_a_gaussian_is_a_step_of_negative_kurtosis() {
        // A box of a third of the variance: its width is sqrt(12 / 3).
        let (half, rest) = (1.0, (2.0_f64 / 3.0).sqrt());
        let kurtosis = -1.2 / 9.0;
        for x in [-2.0, -1.0, -0.3, 0.5, 1.5, 2.5] {
            let parts = 2000;
            let sum: f64 = (0..parts)
                .map(|i| distribution((x + half * (2.0 * (f64::from(i) + 0.5) / f64::from(parts) - 1.0)) / rest))
                .sum();
            let exact = sum / f64::from(parts);
            assert!(
                (step(x, kurtosis) - exact).abs() < 1.5e-3,
                "{x}: {} {exact}",
                step(x, kurtosis)
            );
            let difference = (step(x + 1e-5, kurtosis) - step(x - 1e-5, kurtosis)) / 2e-5;
            // The distribution's own error of 7.5e-8 over the step of 2e-5.
            assert!((slope(x, kurtosis) - difference).abs() < 1e-2);
        }
    }
}
