//! The check after a registration: a known point is touched, and its error is held against what was predicted.

use geometry::{Ct, Frame, Point, Uncertain, UncertainPoint, Vector};
use nalgebra::Matrix3;

use calib::pose::radius_95_mm;

/// Beyond so many times the radius that holds 95 % of errors, an error is no accident: one in 15 000 for an error that is
/// as likely in every direction, one in 300 for one along a line.
pub const FAIL_RATIO: f64 = 1.5;

/// What is accepted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// The greatest error that the operation allows, mm; `None`: only the prediction counts.
    pub most_mm: Option<f64>,
}

/// What a check says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The error is within what was predicted and within the limit.
    Pass,
    /// It is outside the predicted 95 %, as one in twenty is, or the prediction itself is beyond the limit.
    Warn,
    /// It is beyond 1.5 times the predicted radius, or beyond the limit.
    Fail,
}

/// The error at a known point.
#[derive(Debug, Clone, Copy)]
pub struct Checked {
    /// Where the registration places the touched point.
    pub place: Point<Ct>,
    /// That minus the known point, mm.
    pub error: Vector<Ct>,
    /// Its length, mm.
    pub distance_mm: f64,
    /// The radius that holds 95 % of errors, by the covariances of registration, touch and known point, mm.
    pub radius_95_mm: f64,
    /// The covariance that this rests on, mm^2.
    pub covariance: Matrix3<f64>,
    /// What follows.
    pub verdict: Verdict,
}

/// Holds the touched point, carried by the registration, against the known one. Exact in the covariances to first order.
///
/// The prediction assumes that the point was not one of those that the registration was made of.
pub fn check<F: Frame>(
    ct_from: &Uncertain<Ct, F>,
    touched: UncertainPoint<F>,
    known: UncertainPoint<Ct>,
    limits: Limits,
) -> Checked {
    let placed = *ct_from * touched;
    let error = placed.point() - known.point();
    let covariance = placed.covariance() + known.covariance();
    let (distance_mm, radius) = (error.norm(), radius_95_mm(&covariance));
    Checked {
        place: placed.point(),
        error,
        distance_mm,
        radius_95_mm: radius,
        covariance,
        verdict: verdict(distance_mm, radius, limits),
    }
}

fn verdict(distance_mm: f64, radius_mm: f64, limits: Limits) -> Verdict {
    // A NaN is within nothing.
    let within = |limit: f64| distance_mm <= limit;
    let allowed = limits.most_mm.is_none_or(within);
    if !allowed || !within(FAIL_RATIO * radius_mm) {
        return Verdict::Fail;
    }
    let vouched = limits.most_mm.is_none_or(|limit| radius_mm <= limit);
    if vouched && within(radius_mm) {
        Verdict::Pass
    } else {
        Verdict::Warn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Rigid, Tracker};
    use nalgebra::Matrix6;

    #[test]
    fn the_error_is_held_against_prediction_and_limit() {
        let limit = |most_mm| Limits { most_mm };
        for (distance, most, expected) in [
            (0.9, None, Verdict::Pass),
            (1.0, None, Verdict::Pass),
            (1.4, None, Verdict::Warn),
            (1.6, None, Verdict::Fail),
            (f64::NAN, None, Verdict::Fail),
            (0.9, Some(2.0), Verdict::Pass),
            // The prediction does not vouch for the limit.
            (0.5, Some(0.8), Verdict::Warn),
            (0.9, Some(0.8), Verdict::Fail),
        ] {
            assert_eq!(verdict(distance, 1.0, limit(most)), expected, "{distance} {most:?}");
        }
    }

    #[test]
    fn the_error_is_a_vector_in_the_patient_with_the_covariances_of_all_three() {
        let ct_from_tracker: Rigid<Ct, Tracker> = Rigid::from_rotation_vector(
            Vector::new(0.0, 0.0, std::f64::consts::FRAC_PI_2),
            Vector::new(10.0, 0.0, 0.0),
        )
        .unwrap();
        let covariance = Matrix6::from_diagonal(&[1e-6, 1e-6, 1e-6, 0.01, 0.01, 0.01].into());
        let registration = Uncertain::new(ct_from_tracker, covariance).unwrap();
        let touched = UncertainPoint::new(Point::new(100.0, 0.0, 0.0), Matrix3::identity() * 0.04).unwrap();
        let known = UncertainPoint::from(Point::new(10.0, 99.0, 0.5));
        let checked = check(&registration, touched, known, Limits::default());
        assert!((checked.error.mm()[1] - 1.0).abs() < 1e-9 && (checked.error.mm()[2] + 0.5).abs() < 1e-9);
        // 0.01 + 0.04, and across the lever of 100.5 mm a milliradian squared.
        let lever = 100.0 * 100.0 + 10.0 * 10.0;
        assert!(
            (checked.covariance[(2, 2)] - (0.05 + 1e-6 * lever)).abs() < 1e-9,
            "{}",
            checked.covariance
        );
        assert_eq!(checked.verdict, Verdict::Fail);
    }
}
