//! A noise that was told, held against the residuals.

use super::few_residuals_factor;

/// The greatest chi-squared of so many degrees of freedom that is one of the noise told: at four normal deviations, by the cube root of Wilson and
/// Hilferty (1931).
pub fn greatest_chi_squared(freedom: u32) -> f64 {
    quantile(freedom, 4.0)
}

/// What the variance of a told noise is multiplied by where residuals show more of it: 1 where they do not, the residuals' own variance
/// over it where that may be chance, and where it is none at 95 % also what few residuals leave open of it ([`few_residuals_factor`]).
pub fn told_noise_factor(chi_squared: f64, freedom: u32) -> f64 {
    let shown = chi_squared / f64::from(freedom.max(1));
    // Beyond what one in twenty shows by chance the noise told is no longer believed, and few residuals are all there is.
    let is_chance = chi_squared <= quantile(freedom, 1.645);
    match is_chance {
        true => shown.max(1.0),
        false => shown * few_residuals_factor(freedom),
    }
}

fn quantile(freedom: u32, deviations: f64) -> f64 {
    // The cube root of chi-squared over its freedom is nearly normal.
    let k = f64::from(freedom.max(1));
    let spread = 2.0 / (9.0 * k);
    k * (1.0 - spread + deviations * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_table() {
        for (freedom, point) in [(3, 7.815), (6, 12.592), (12, 21.026), (24, 36.415)] {
            // Wilson and Hilferty's cube root: 0.6 % at three degrees of freedom, less above.
            assert!((quantile(freedom, 1.645) / point - 1.0).abs() < 0.006, "{freedom}");
        }
    }

    #[test]
    fn a_noise_that_residuals_bear_out_stays_as_it_was_told() {
        assert_eq!(told_noise_factor(2.9, 3), 1.0);
        assert_eq!(told_noise_factor(6.0, 3), 2.0);
        // Of 3 degrees of freedom F at 95 % is 9.28, over 2.60 for a known noise.
        assert!((told_noise_factor(9.0, 3) - 3.0 * 9.277 / 2.605).abs() < 0.01);
        assert!(told_noise_factor(60.0, 30) > 2.0);
    }
}
