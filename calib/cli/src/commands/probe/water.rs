//! Calibrating in water, where sound is slower than a scanner believes: points are put where they would be shown by its own speed.

use serde::{Deserialize, Serialize};

/// The speed of sound that scanners reckon with, m/s.
pub(super) const SCANNER_M_S: f64 = 1540.0;
/// Temperatures that the formula is for, degrees Celsius.
pub(super) const CELSIUS: std::ops::RangeInclusive<f64> = 0.0..=95.0;
/// Up to here water is the faster the warmer it is.
const FASTEST_C: f64 = 74.0;

/// The water that a probe was calibrated in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WaterRecord {
    /// Its temperature, degrees Celsius, as told.
    pub celsius: f64,
    /// The speed of sound in it, m/s.
    pub speed_m_s: f64,
    /// The speed that the scanner reckons with, m/s: the file's image is that of tissue in which sound has it.
    pub scanner_m_s: f64,
}

impl WaterRecord {
    pub(super) fn new(celsius: f64, scanner_m_s: f64) -> Self {
        Self {
            celsius,
            speed_m_s: speed_m_s(celsius),
            scanner_m_s,
        }
    }

    /// Depths are so many times what is shown.
    pub(super) fn share(&self) -> f64 {
        self.speed_m_s / self.scanner_m_s
    }

    pub(super) fn words(&self) -> String {
        format!(
            "water            {:.1} C: sound at {:.1} m/s, {:.1} % slower than the scanner's {:.0}; the image is that of sound at the scanner's\n",
            self.celsius,
            self.speed_m_s,
            100.0 * (1.0 - self.share()),
            self.scanner_m_s
        )
    }
}

/// The speed of sound in pure water at the pressure of the air, m/s; `celsius` within [`CELSIUS`]. Marczak, J. Acoust. Soc. Am. 102 (1997)
/// 2776, a polynomial of the fifth degree through three data sets on the scale of 1990; off by 0.02 m/s (as its author says; the
/// coefficients were read in other software that cites it).
pub(crate) fn speed_m_s(celsius: f64) -> f64 {
    const COEFFICIENTS: [f64; 6] = [
        1.402385e3,
        5.038813,
        -5.799136e-2,
        3.287156e-4,
        -1.398845e-6,
        2.787860e-9,
    ];
    COEFFICIENTS.iter().rev().fold(0.0, |sum, c| sum * celsius + c)
}

/// The temperature of water below 74 degrees in which depths are shown so many times too long by a usual scanner; `None` where they are in
/// none.
pub(crate) fn celsius_of(shown_over_true: f64) -> Option<f64> {
    let sought = SCANNER_M_S / shown_over_true;
    let (mut low, mut high) = (*CELSIUS.start(), FASTEST_C);
    if !(speed_m_s(low)..=speed_m_s(high)).contains(&sought) {
        return None;
    }
    // Bisection to 1e-6 degrees.
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if speed_m_s(middle) < sought {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::super::array::ArrayRecord;
    use super::*;

    /// Del Grosso and Mader (1972), whose table all later formulas are held against.
    #[test]
    fn the_speed_of_sound_in_water_is_that_of_the_tables() {
        for (celsius, m_s) in [(0.0, 1402.388), (20.0, 1482.343), (25.0, 1496.687), (50.0, 1542.551)] {
            let found = speed_m_s(celsius);
            // Both are said to be off by some hundredths.
            assert!((found - m_s).abs() < 0.05, "{celsius}: {found} {m_s}");
        }
        let fastest = (0..=950).map(|i| f64::from(i) / 10.0);
        let fastest = fastest.max_by(|a, b| speed_m_s(*a).total_cmp(&speed_m_s(*b))).unwrap();
        assert!((fastest - FASTEST_C).abs() < 0.5, "{fastest}");
    }

    #[test]
    fn a_temperature_is_told_of_how_much_too_long_depths_are_shown() {
        for celsius in [0.5, 20.0, 37.0, 73.0] {
            let found = celsius_of(SCANNER_M_S / speed_m_s(celsius)).unwrap();
            assert!((found - celsius).abs() < 1e-4, "{found} {celsius}");
        }
        assert_eq!(celsius_of(1.2), None);
        assert_eq!(celsius_of(0.9), None);
    }

    /// A curved array's beams lean: a point goes along its own, and what lies on the face stays.
    #[test]
    fn points_go_along_their_beams() {
        let linear = ArrayRecord::Linear {
            from_px: 0.0,
            to_px: 200.0,
            face_px: 10.0,
        };
        assert_eq!(linear.at_depth([70.0, 110.0], 0.96), [70.0, 106.0]);
        let curved = ArrayRecord::Curved {
            centre_px: [100.0, -300.0],
            radius_px: 310.0,
            angle_deg: 60.0,
        };
        let [u, v] = curved.at_depth([100.0 + 0.6 * 400.0, -300.0 + 0.8 * 400.0], 0.9);
        // 90 below the face become 81.
        assert!((u - (100.0 + 0.6 * 391.0)).abs() < 1e-9 && (v - (-300.0 + 0.8 * 391.0)).abs() < 1e-9);
        let face = curved.at_depth([100.0, 10.0], 0.9);
        assert!((face[0] - 100.0).abs() < 1e-9 && (face[1] - 10.0).abs() < 1e-9);
    }
}
