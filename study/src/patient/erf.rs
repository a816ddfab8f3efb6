//! The error function.

/// `erf(x)`, to 1e-12 absolute.
///
/// Below 3 by its series `2 / sqrt(pi) exp(-x^2) sum (2 x^2)^k x / (1 3 5 ... (2 k + 1))` (Abramowitz and Stegun 1964, 7.1.6), whose
/// terms are all positive; from 3 on by the continued fraction of erfc (7.1.14), of which 60 terms leave less than 1e-15.
pub(super) fn erf(x: f64) -> f64 {
    let a = x.abs();
    let value = match a {
        a if a < 3.0 => series(a),
        a if a < 6.5 => 1.0 - complement(a),
        _ => 1.0,
    };
    value.copysign(x)
}

fn series(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    let mut k = 1.0;
    while term > 1e-17 * sum {
        term *= 2.0 * x * x / (2.0 * k + 1.0);
        sum += term;
        k += 1.0;
    }
    std::f64::consts::FRAC_2_SQRT_PI * (-x * x).exp() * sum
}

fn complement(x: f64) -> f64 {
    let mut tail = x;
    for k in (1..=60).rev() {
        tail = x + f64::from(k) / 2.0 / tail;
    }
    (-x * x).exp() / std::f64::consts::PI.sqrt() / tail
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun 1964, table 7.1, and erfc of table 7.2 beyond it: ten digits.
    #[test]
    fn has_the_values_of_the_tables() {
        for (x, expected) in [
            (0.0, 0.0),
            (0.5, 0.520_499_877_8),
            (1.0, 0.842_700_792_9),
            (1.5, 0.966_105_146_5),
            (2.0, 0.995_322_265_0),
            (2.999_999, 0.999_977_909_4),
            (3.0, 0.999_977_909_5),
            (3.000_001, 0.999_977_909_6),
            (7.0, 1.0),
        ] {
            assert!((erf(x) - expected).abs() < 2e-10, "{x}: {}", erf(x));
            assert!((erf(-x) + expected).abs() < 2e-10, "{x}");
        }
        assert!((series(3.0) - (1.0 - complement(3.0))).abs() < 1e-13);
    }
}
