//! Calibrating in water, where sound is slower than a scanner believes: points are put where they would be shown by its own speed.

use serde::{Deserialize, Serialize};
pub(super) use ultrasound::SCANNER_M_S;
use ultrasound::water_m_s;

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
            speed_m_s: water_m_s(celsius),
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

/// The temperature of water below 74 degrees in which depths are shown so many times too long by a usual scanner; `None` where they are in
/// none.
pub(crate) fn celsius_of(shown_over_true: f64) -> Option<f64> {
    let sought = SCANNER_M_S / shown_over_true;
    let (mut low, mut high) = (*CELSIUS.start(), FASTEST_C);
    if !(water_m_s(low)..=water_m_s(high)).contains(&sought) {
        return None;
    }
    // Bisection to 1e-6 degrees.
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if water_m_s(middle) < sought {
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

    /// Up to there a speed has one temperature, which the bisection rests on.
    #[test]
    fn water_is_the_faster_the_warmer_it_is_up_to_74_degrees() {
        let fastest = (0..=950).map(|i| f64::from(i) / 10.0);
        let fastest = fastest.max_by(|a, b| water_m_s(*a).total_cmp(&water_m_s(*b))).unwrap();
        assert!((fastest - FASTEST_C).abs() < 0.5, "{fastest}");
    }

    #[test]
    fn a_temperature_is_told_of_how_much_too_long_depths_are_shown() {
        for celsius in [0.5, 20.0, 37.0, 73.0] {
            let found = celsius_of(SCANNER_M_S / water_m_s(celsius)).unwrap();
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
