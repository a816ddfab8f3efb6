//! How much more a covariance must be where its noise was estimated from few residuals.

/// The 95 % point of chi-squared with 3 degrees of freedom.
const CHI_SQUARED_95: f64 = 7.814_727_903_251_178;
/// Cells of the integral.
const CELLS: u32 = 4000;

/// `F_0.95(3, nu) / F_0.95(3, inf)`, at least 1: what a covariance by the variance of residuals of `nu` degrees of freedom is multiplied
/// by, so that the radius that holds 95 % of errors of known noise holds 95 % of them.
///
/// The square of an error alike in all directions, over the variance that was estimated beside it, follows F(3, nu) and not chi-squared
/// (Hotelling 1931). With `f = nu / 3 tan^2 a` its density is that of `sin^2 a cos^(nu - 1) a`. For an error along a line the factor is
/// somewhat too large: 96.6 % for three pairs. Error: 1e-5 of itself. Infinite for `nu = 0`.
pub fn few_residuals_factor(nu: u32) -> f64 {
    if nu == 0 {
        return f64::INFINITY;
    }
    let nu = f64::from(nu);
    // Beyond 12 / sqrt(nu) the density is below exp(-70) of its greatest.
    let end = (12.0 / nu.sqrt()).min(std::f64::consts::FRAC_PI_2);
    let step = end / f64::from(CELLS);
    let density = |cell: u32| {
        let (sine, cosine) = ((f64::from(cell) + 0.5) * step).sin_cos();
        sine * sine * cosine.powf(nu - 1.0)
    };
    let wanted = 0.95 * (0..CELLS).map(density).sum::<f64>();
    let mut sum = 0.0;
    for cell in 0..CELLS {
        let next = sum + density(cell);
        if next >= wanted {
            // Within the cell the density is even, to the square of the step.
            let angle = (f64::from(cell) + (wanted - sum) / (next - sum)) * step;
            return (nu * angle.tan().powi(2) / CHI_SQUARED_95).max(1.0);
        }
        sum = next;
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the printed table of F at 0.95 with 3 degrees of freedom above.
    #[test]
    fn the_factor_is_that_of_the_table() {
        for (nu, f) in [
            (2, 19.16),
            (3, 9.28),
            (6, 4.76),
            (9, 3.86),
            (12, 3.49),
            (24, 3.01),
            (120, 2.68),
        ] {
            let found = few_residuals_factor(nu) * CHI_SQUARED_95 / 3.0;
            // The table has two decimals.
            assert!((found - f).abs() < 0.0051, "{nu}: {found}");
        }
        assert!(few_residuals_factor(0).is_infinite());
        let many = few_residuals_factor(30_000);
        assert!((1.0..1.0002).contains(&many), "{many}");
    }
}
