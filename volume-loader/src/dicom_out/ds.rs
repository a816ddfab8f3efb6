//! Numbers as decimal strings, DS of PS3.5 section 6.2: at most 16 characters.

/// Most characters of one DS value.
const LENGTH: usize = 16;

/// `value` with as many digits as 16 characters hold; a magnitude that fixed digits do not hold is written with an exponent.
pub(crate) fn decimal_string(value: f64) -> String {
    // One digit and the point are the least in front of the decimals.
    for decimals in (0..=LENGTH - 2).rev() {
        let text = format!("{value:.decimals$}");
        if text.len() <= LENGTH {
            return plain(&text).to_owned();
        }
    }
    // A sign, a digit, the point, 8 decimals and an exponent of at most 4 characters.
    format!("{value:.8e}")
}

/// Without zeros that say nothing; minus zero is zero.
fn plain(text: &str) -> &str {
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    };
    if text == "-0" { "0" } else { text }
}

/// Values of one element, between backslashes.
pub(crate) fn decimal_strings<const N: usize>(values: [f64; N]) -> String {
    values.map(decimal_string).join("\\")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn known_numbers() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (-1e-30, "0"),
            (1.0, "1"),
            (-120.0, "-120"),
            (1.5, "1.5"),
            (1.0 / 3.0, "0.33333333333333"),
            (-1.0 / 3.0, "-0.3333333333333"),
            (-123.456_789_012_345, "-123.45678901234"),
            (1e15, "1000000000000000"),
            (1e16, "1.00000000e16"),
            (-1.5e300, "-1.50000000e300"),
        ];
        for (value, want) in cases {
            assert_eq!(decimal_string(value), want, "{value}");
        }
        assert_eq!(decimal_strings([1.0, -0.5]), "1\\-0.5");
    }

    proptest! {
        #[test]
        fn places_in_a_patient_are_exact_to_a_hundredth_of_a_nanometre(value in -9999.0..9999.0) {
            let text = decimal_string(value);
            prop_assert!(text.len() <= 16, "{}", text);
            prop_assert!((text.parse::<f64>().unwrap() - value).abs() <= 5.1e-11, "{} for {}", text, value);
        }

        #[test]
        fn every_number_fits(value in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO) {
            let text = decimal_string(value);
            prop_assert!(text.len() <= 16, "{}", text);
            prop_assert!((text.parse::<f64>().unwrap() - value).abs() <= value.abs() * 5.1e-9 + 5.1e-14, "{} for {}", text, value);
        }
    }
}
