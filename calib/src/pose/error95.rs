//! The radius that holds 95 % of a normal error.

use nalgebra::Matrix3;

/// The radius, mm, of the ball about the true place that holds 95 % of normal errors of this covariance (mm^2).
///
/// The squared length is a sum of squares with the covariance's eigenvalues; its quantile is that of the chi-squared law
/// with the same three first cumulants (Hall 1983; Buckley and Eagleson 1988), which need no eigenvalues: exact for one,
/// two or three equal ones, and holding between 95.0 and 95.3 % otherwise. Zero for a zero covariance.
pub fn radius_95_mm(covariance_mm2: &Matrix3<f64>) -> f64 {
    let scale = covariance_mm2.trace();
    if scale <= 0.0 {
        return 0.0;
    }
    // With the trace 1 the mean k1 is 1, and cubes neither overflow nor vanish.
    let c = covariance_mm2 / scale;
    let square = c * c;
    let (k2, k3) = (2.0 * square.trace(), 8.0 * (square * c).trace());
    // Chi-squared with f degrees has the squared skewness 8 / f; one to three equal eigenvalues give f = 1 to 3, and
    // rounding may lead just beyond.
    let freedom = (8.0 * k2 * k2 * k2 / (k3 * k3)).clamp(1.0, 3.0);
    let quantile = 1.0 + (k2 / (2.0 * freedom)).sqrt() * (chi_squared_95(freedom) - freedom);
    (quantile * scale).sqrt()
}

/// The 95 % point of chi-squared with 1 to 3 degrees of freedom, to 3e-4: least squares on its values.
fn chi_squared_95(freedom: f64) -> f64 {
    const C: [f64; 6] = [
        5.991_394_386_6,
        1.936_907_382_9,
        -0.143_957_261_9,
        0.041_844_957_6,
        -0.019_107_051_5,
        0.007_826_832_6,
    ];
    // About the middle of the domain, so that no power is above 1.
    let x = freedom - 2.0;
    C.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn equal_eigenvalues_have_the_points_of_the_tables() {
        // Chi-squared, 95 %: 3.841459, 5.991465, 7.814728.
        for (diagonal, square) in [
            ([4.0, 0.0, 0.0], 3.841459),
            ([4.0, 4.0, 0.0], 5.991465),
            ([4.0; 3], 7.814728),
        ] {
            let radius = radius_95_mm(&Matrix3::from_diagonal(&Vector3::from(diagonal)));
            // 3e-4 of chi-squared is 4e-5 of its root at 3.8.
            assert!((radius / (4.0_f64 * square).sqrt() - 1.0).abs() < 5e-5, "{diagonal:?}");
        }
        assert_eq!(radius_95_mm(&Matrix3::zeros()), 0.0);
    }

    /// Share of the mass within the radius, by sums over a fine grid of two coordinates and the error function.
    fn mass(diagonal: [f64; 3]) -> f64 {
        let radius = radius_95_mm(&Matrix3::from_diagonal(&Vector3::from(diagonal)));
        let n = 1200;
        let step = 2.0 * 8.0 / f64::from(n);
        let density = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
        let mut sum = 0.0;
        for i in 0..n {
            let x = -8.0 + (f64::from(i) + 0.5) * step;
            for j in 0..n {
                let y = -8.0 + (f64::from(j) + 0.5) * step;
                let rest = radius * radius - diagonal[0] * x * x - diagonal[1] * y * y;
                // The least deviation is much smaller: it counts as zero.
                sum += if rest > 0.0 { density(x) * density(y) } else { 0.0 };
            }
        }
        sum * step * step
    }

    #[test]
    fn two_unequal_eigenvalues_hold_95_percent() {
        for ratio in [0.05, 0.2, 0.4, 0.7, 1.0] {
            let held = mass([1.0, ratio, 0.0]);
            // 95.0 to 95.26 % by quadrature; the grid's own error is below 1e-4.
            assert!((0.9498..0.9528).contains(&held), "{ratio}: {held}");
        }
    }
}
