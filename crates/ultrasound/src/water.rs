//! The speed of sound in water, and the one that scanners reckon with.

/// The speed of sound that scanners reckon with, m/s.
pub const SCANNER_M_S: f64 = 1540.0;

/// The speed of sound in pure water at the pressure of the air, m/s, for 0 to 95 degrees Celsius. Marczak, J. Acoust. Soc. Am. 102 (1997)
/// 2776, a polynomial of the fifth degree through three data sets on the scale of 1990; off by 0.02 m/s (as its author says; the
/// coefficients were read in other software that cites it).
#[must_use]
pub fn water_m_s(celsius: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Del Grosso and Mader (1972), whose table all later formulas are held against.
    #[test]
    fn the_speed_of_sound_in_water_is_that_of_the_tables() {
        for (celsius, m_s) in [(0.0, 1402.388), (20.0, 1482.343), (25.0, 1496.687), (50.0, 1542.551)] {
            let found = water_m_s(celsius);
            // Both are said to be off by some hundredths.
            assert!((found - m_s).abs() < 0.05, "{celsius}: {found} {m_s}");
        }
    }
}
