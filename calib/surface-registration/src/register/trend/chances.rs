//! Chances as deviations of a normal number.

/// An F of `m` over `n` degrees of freedom as deviations of a normal number (Paulson 1942): to 0.05 of them from three degrees on.
pub(super) fn deviations_of_f(f: f64, m: f64, n: f64) -> f64 {
    let (a, b, root) = (2.0 / (9.0 * m), 2.0 / (9.0 * n), f.max(0.0).cbrt());
    ((1.0 - b) * root - (1.0 - a)) / (a + b * root * root).sqrt()
}

/// The greatest of so many independent numbers, as deviations of one.
pub(super) fn of_many(deviations: f64, count: f64) -> f64 {
    inverse_upper(upper(deviations) * count)
}

/// What a normal number is above with this chance.
fn inverse_upper(above: f64) -> f64 {
    // By halving, to rounding.
    let (mut low, mut high) = (-8.0, 38.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if upper(middle) > above {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The square that the greatest of so many independent normal numbers, of either sign, is above one time in twenty.
pub(super) fn greatest_square(count: f64) -> f64 {
    inverse_upper(0.025 / count).powi(2)
}

/// So many and more of `of`, each with the chance `share`, as deviations of a normal number.
pub(crate) fn deviations_of_count(count: usize, of: usize, share: f64) -> f64 {
    // Terms of the binomial law from `of` down to `count`, each from the one above; as logarithms, as the first may be below any number.
    let (mut term, mut above) = (of as f64 * share.ln(), 0.0);
    for k in (count..=of).rev() {
        above += term.exp();
        term += (k as f64 / (of - k + 1) as f64 * (1.0 - share) / share).ln();
    }
    inverse_upper(above)
}

/// The chance of a normal number above this: by its series near 0 and by the continued fraction of Mills' ratio further out (Abramowitz and
/// Stegun 26.2.11 and 26.2.14), to 1e-10 of itself.
pub(super) fn upper(x: f64) -> f64 {
    if x < 0.0 {
        return 1.0 - upper(-x);
    }
    let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    if x > 3.0 {
        let fraction = (1..100).rev().fold(x, |below, k| x + f64::from(k) / below);
        return density / fraction;
    }
    let (mut term, mut sum) = (x, x);
    for k in 1..60 {
        term *= x * x / f64::from(2 * k + 1);
        sum += term;
    }
    0.5 - density * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_are_those_of_the_tables() {
        for (x, above) in [
            (0.0, 0.5),
            (1.644_853_627, 0.05),
            (3.090_232_306, 1e-3),
            (4.753_424_309, 1e-6),
            (-1.644_853_627, 0.95),
        ] {
            // The printed digits.
            assert!((upper(x) / above - 1.0).abs() < 1e-8, "{x}: {}", upper(x));
        }
        // Ten numbers: the chance of 1e-4 of each is 1e-3 of the greatest.
        assert!((of_many(3.719_016_485, 10.0) - 3.090_232_306).abs() < 1e-6);
        // (1/3)^8 is 1.524e-4, which is beyond 3.611 deviations; of 30 shares of a half and more is hardly chance at a third.
        assert!((upper(deviations_of_count(8, 8, 1.0 / 3.0)) * 6561.0 - 1.0).abs() < 1e-9);
        assert!(
            deviations_of_count(700, 3000, 1.0 / 3.0) < -8.0 + 1e-6 && deviations_of_count(1100, 3000, 1.0 / 3.0) > 3.0
        );
        assert!((upper(deviations_of_count(0, 9, 0.4)) - 1.0).abs() < 1e-9);
        assert!((of_many(0.3, 1.0) - 0.3).abs() < 1e-9);
    }

    #[test]
    fn f_is_that_of_the_tables() {
        // F at 0.999 of the printed tables.
        for (m, n, f) in [
            (1.0, 30.0, 13.29),
            (6.0, 30.0, 5.12),
            (6.0, 60.0, 4.37),
            (1.0, 120.0, 11.38),
        ] {
            let found = deviations_of_f(f, m, n);
            assert!((found - 3.090).abs() < 0.06, "{m} {n}: {found}");
        }
    }
}
