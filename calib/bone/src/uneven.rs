//! Blur that goes with the direction as no model here has it: wider along one axis of the slice than along the other, or about an axis that
//! is not the slices'.
//!
//! What each place says of the logarithm of its own blur, beside what all share, is fitted by a quadratic form of its normal, which a
//! covariance of any axes is to first order. Its root mean square over the places, less what noise makes of it, is how wrong the blur is
//! at a place though right on average.

use nalgebra::{Matrix6, Vector3, Vector6};

/// Deviation of the form's entries beforehand.
const PRIOR: f64 = 0.5;

/// What a place says of the logarithm of the blur along its normal.
pub(crate) struct Says {
    pub(crate) normal: Vector3<f64>,
    /// Information and gradient of its cost, as they count among others.
    pub(crate) information: f64,
    pub(crate) gradient: f64,
}

/// Root mean square, over the places, of what the logarithm of the blur is off by their directions.
pub(crate) fn uneven(said: &[Says]) -> f64 {
    let row = |n: &Vector3<f64>| Vector6::new(n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.y * n.z, n.z * n.x);
    let mut matrix = Matrix6::identity() / (PRIOR * PRIOR);
    let mut right = Vector6::zeros();
    for place in said {
        let row = row(&place.normal);
        matrix += place.information * row * row.transpose();
        right -= place.gradient * row;
    }
    let Some(inverse) = matrix.try_inverse() else {
        return PRIOR;
    };
    let form = inverse * right;
    // What noise alone makes of the form's square at a place is its variance there.
    let square = |place: &Says| {
        let row = row(&place.normal);
        row.dot(&form).powi(2) - row.dot(&(inverse * row))
    };
    let mean = said.iter().map(square).sum::<f64>() / (said.len() as f64).max(1.0);
    mean.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places all around, of which each says by `found` what its blur is off.
    fn places(found: impl Fn(&Vector3<f64>) -> f64) -> Vec<Says> {
        let places = (0..300).map(|i| {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 300.0;
            let (turn, flat) = (2.399_963 * f64::from(i), (1.0 - z * z).sqrt());
            let normal = Vector3::new(flat * turn.cos(), flat * turn.sin(), z);
            let gradient = -100.0 * found(&normal);
            Says {
                normal,
                information: 100.0,
                gradient,
            }
        });
        places.collect()
    }

    #[test]
    fn blur_that_is_wider_along_one_axis_is_found_and_an_even_one_is_not() {
        // Of a (x^2 - y^2) the mean square over a ball is 4 a^2 / 15.
        let found = uneven(&places(|n| 0.4 * (n.x * n.x - n.y * n.y)));
        assert!((found - 0.4 * (4.0_f64 / 15.0).sqrt()).abs() < 0.005, "{found}");
        assert_eq!(uneven(&places(|_| 0.0)), 0.0);
    }
}
