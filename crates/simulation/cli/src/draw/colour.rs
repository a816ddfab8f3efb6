//! Colours of numbers: two maps whose lightness runs evenly, so that equal steps look equal and print in grey.

use picture::Rgb;

/// What a number is shown as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ramp {
    /// Shown at the lower end.
    pub(crate) low: f64,
    /// Shown at the upper end.
    pub(crate) high: f64,
    /// Blue below zero, white at zero, red above.
    pub(crate) signed: bool,
    /// Colours go with the square root of a number: small ones are told apart too.
    pub(crate) root: bool,
}

/// Coefficients of degree 0 to 6 of red, green and blue: a fit of viridis, the map of van der Walt and Smith (2015).
const VIRIDIS: [[f64; 3]; 7] = [
    [0.277_727_327, 0.005_407_345, 0.334_099_805],
    [0.105_093_043, 1.404_613_530, 1.384_590_163],
    [-0.330_861_829, 0.214_847_559, 0.095_095_163],
    [-4.634_230_499, -5.799_100_973, -19.332_440_956],
    [6.228_269_936, 14.179_933_367, 56.690_552_601],
    [4.776_384_998, -13.745_145_378, -65.353_032_633],
    [-5.435_455_856, 4.645_852_612, 26.312_435_250],
];

/// Ends of the signed map in Oklab (Ottosson 2020): lightness and two opponents. White is between them.
const PRESSED: [f64; 3] = [0.45, -0.03, -0.17];
const PULLED: [f64; 3] = [0.45, 0.16, 0.09];
const WHITE: [f64; 3] = [0.98, 0.0, 0.0];

impl Ramp {
    /// From zero to `high`.
    pub(crate) fn from_zero(high: f64) -> Self {
        Self {
            low: 0.0,
            high: usable(high),
            signed: false,
            root: false,
        }
    }

    /// From `-high` to `high`.
    pub(crate) fn about_zero(high: f64) -> Self {
        let high = usable(high);
        Self {
            low: -high,
            high,
            signed: true,
            root: false,
        }
    }

    /// The same range with colours that go with the square root.
    pub(crate) fn rooted(self) -> Self {
        Self { root: true, ..self }
    }

    /// The colour of a number; beyond an end, that end's. Grey for what is no number.
    pub(crate) fn colour(&self, x: f64) -> Rgb {
        let x = if self.root {
            x.signum() * (x.abs() * self.high).sqrt()
        } else {
            x
        };
        let t = (x - self.low) / (self.high - self.low);
        if t.is_nan() {
            return Rgb(150, 150, 150);
        }
        let t = t.clamp(0.0, 1.0);
        if self.signed { signed(t) } else { viridis(t) }
    }
}

/// A range needs a length.
fn usable(high: f64) -> f64 {
    if high.is_finite() && high > 0.0 { high } else { 1.0 }
}

fn byte(x: f64) -> u8 {
    (255.0 * x).round().clamp(0.0, 255.0) as u8
}

fn viridis(t: f64) -> Rgb {
    let value = |c: usize| byte(VIRIDIS.iter().rev().fold(0.0, |sum, k| sum * t + k[c]));
    Rgb(value(0), value(1), value(2))
}

fn signed(t: f64) -> Rgb {
    let (end, part) = if t < 0.5 {
        (PRESSED, 1.0 - 2.0 * t)
    } else {
        (PULLED, 2.0 * t - 1.0)
    };
    let mix: [f64; 3] = std::array::from_fn(|i| WHITE[i] + (end[i] - WHITE[i]) * part);
    from_oklab(mix)
}

fn from_oklab([l, a, b]: [f64; 3]) -> Rgb {
    let long = (l + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let medium = (l - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let short = (l - 0.089_484_177_5 * a - 1.291_485_548 * b).powi(3);
    let gamma = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        if x <= 0.003_130_8 {
            12.92 * x
        } else {
            1.055 * x.powf(1.0 / 2.4) - 0.055
        }
    };
    let linear = [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701 * short,
    ];
    let [r, g, b] = linear.map(|x| byte(gamma(x)));
    Rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness of a colour, 0 to 100.
    fn lightness(Rgb(r, g, b): Rgb) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        };
        let y = 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
        if y > 0.008_856 {
            116.0 * y.cbrt() - 16.0
        } else {
            903.3 * y
        }
    }

    #[test]
    fn lightness_runs_evenly() {
        let steps = |ramp: Ramp, from: f64, to: f64| -> Vec<f64> {
            let at = |k: u32| lightness(ramp.colour(from + (to - from) * f64::from(k) / 16.0));
            (0..16).map(|k| at(k + 1) - at(k)).collect()
        };
        let ramps = [
            (Ramp::from_zero(1.0), 0.0, 1.0),
            (Ramp::about_zero(1.0), -1.0, 0.0),
            (Ramp::about_zero(1.0), 1.0, 0.0),
        ];
        for (ramp, from, to) in ramps {
            let steps = steps(ramp, from, to);
            let mean = steps.iter().sum::<f64>() / 16.0;
            assert!(mean > 2.5, "{mean}");
            // The fit of viridis departs from it by a few steps of 255; Oklab's lightness is not CIE's.
            for step in &steps {
                assert!(*step > 0.4 * mean && *step < 1.6 * mean, "{step} of {mean}: {steps:?}");
            }
        }
    }

    #[test]
    fn roots_keep_ends_and_spread_what_is_small() {
        for ramp in [Ramp::from_zero(4.0), Ramp::about_zero(4.0)] {
            for end in [0.0, 4.0, ramp.low] {
                assert_eq!(ramp.rooted().colour(end), ramp.colour(end));
            }
            assert_eq!(ramp.rooted().colour(1.0), ramp.colour(2.0));
        }
        assert_eq!(
            Ramp::about_zero(4.0).rooted().colour(-1.0),
            Ramp::about_zero(4.0).colour(-2.0)
        );
    }

    #[test]
    fn ends_hold_and_what_is_no_number_is_grey() {
        let ramp = Ramp::about_zero(2.0);
        assert_eq!(ramp.colour(9.0), ramp.colour(2.0));
        assert_eq!(ramp.colour(-9.0), ramp.colour(-2.0));
        let Rgb(r, g, b) = ramp.colour(0.0);
        assert!(r == g && g == b && r > 240);
        assert_eq!(ramp.colour(f64::NAN), Rgb(150, 150, 150));
        assert_eq!(Ramp::from_zero(f64::NAN).high, 1.0);
        assert_eq!(Ramp::from_zero(0.0).high, 1.0);
    }
}
