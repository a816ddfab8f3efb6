//! The special functions of a blurred ball, each to about 2e-7: a thousandth of a HU on the densest metal.

/// `erf(x)` and `exp(-x^2)`: Abramowitz and Stegun (1964) 7.1.26, absolute error at most 1.5e-7.
pub(super) fn erf_and_exp(x: f64) -> (f64, f64) {
    const C: [f64; 5] = [
        0.254_829_592,
        -0.284_496_736,
        1.421_413_741,
        -1.453_152_027,
        1.061_405_429,
    ];
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let exp = (-x * x).exp();
    let sum = t * (C[0] + t * (C[1] + t * (C[2] + t * (C[3] + t * C[4]))));
    ((1.0 - sum * exp).copysign(x), exp)
}

/// `exp(-x) I0(x)` and `exp(-x) I1(x)` for `x >= 0`: Abramowitz and Stegun (1964) 9.8.1 to 9.8.4, relative error at most
/// 3e-7.
pub(super) fn bessel_scaled(x: f64) -> (f64, f64) {
    // Two fits of the source meet at 3.75; beyond, exp(-x) is in the series already and cannot overflow.
    if x < 3.75 {
        let t = (x / 3.75) * (x / 3.75);
        let i0 = polynomial(
            t,
            &[
                1.0,
                3.515_622_9,
                3.089_942_4,
                1.206_749_2,
                0.265_973_2,
                0.036_076_8,
                0.004_581_3,
            ],
        );
        let i1 = polynomial(
            t,
            &[
                0.5,
                0.878_905_94,
                0.514_988_69,
                0.150_849_34,
                0.026_587_33,
                0.003_015_32,
                0.000_324_11,
            ],
        );
        let exp = (-x).exp();
        return (i0 * exp, i1 * x * exp);
    }
    let t = 3.75 / x;
    let i0 = [
        0.398_942_28,
        0.013_285_92,
        0.002_253_19,
        -0.001_575_65,
        0.009_162_81,
        -0.020_577_06,
        0.026_355_37,
        -0.016_476_33,
        0.003_923_77,
    ];
    let i1 = [
        0.398_942_28,
        -0.039_880_24,
        -0.003_620_18,
        0.001_638_01,
        -0.010_315_55,
        0.022_829_67,
        -0.028_953_12,
        0.017_876_54,
        -0.004_200_59,
    ];
    let root = x.sqrt();
    (polynomial(t, &i0) / root, polynomial(t, &i1) / root)
}

fn polynomial(x: f64, coefficients: &[f64]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_function_has_the_values_of_the_tables() {
        // Abramowitz and Stegun 1964, table 7.1.
        for (x, value) in [
            (0.0, 0.0),
            (0.1, 0.112_462_916_0),
            (0.5, 0.520_499_877_8),
            (1.0, 0.842_700_792_9),
            (2.0, 0.995_322_265_0),
        ] {
            for sign in [1.0, -1.0] {
                let (erf, exp) = erf_and_exp(sign * x);
                assert!((erf - sign * value).abs() < 1.6e-7, "{x}: {erf}");
                assert_eq!(exp, (-x * x).exp());
            }
        }
    }

    #[test]
    fn bessel_functions_are_means_over_a_circle() {
        for i in 0..400 {
            let x = f64::from(i) * 0.1;
            let (mut i0, mut i1) = (0.0, 0.0);
            // The trapezoid rule on a circle: 200 points are exact to rounding up to x = 40.
            for k in 0..200 {
                let cos = (f64::from(k) * std::f64::consts::TAU / 200.0).cos();
                let term = (x * (cos - 1.0)).exp() / 200.0;
                i0 += term;
                i1 += term * cos;
            }
            let (a, b) = bessel_scaled(x);
            assert!(
                (a - i0).abs() < 3e-7 * i0 && (b - i1).abs() < 3e-7 * i0,
                "{x}: {a} {i0}"
            );
        }
    }
}
