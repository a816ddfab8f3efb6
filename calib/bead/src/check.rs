//! The check after a registration: a known point is touched, and its error is held against what was predicted.

use geometry::{Ct, Frame, Point, Uncertain, UncertainPoint, Vector};
use nalgebra::{Matrix3, Matrix3x6, Matrix6x3};

use calib::pose::radius_95_mm;

/// Beyond so many times the radius that holds 95 % of errors, an error is no accident: one in 15 000 for an error that is
/// as likely in every direction, one in 300 for one along a line; where the noise was estimated from three, four or six pairs, 16, 8 or 4 in
/// 1000.
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
    /// The radius that holds 95 % of errors where nothing has moved, by [`Checked::covariance`], mm.
    pub radius_95_mm: f64,
    /// The same by the covariances of registration, touch and known point as if they erred independently, mm: what is promised of a
    /// place that the tip's calibration does not cancel in. It is held against the limit, as the larger of the two.
    pub apart_radius_95_mm: f64,
    /// The covariance that this rests on, mm^2.
    pub covariance: Matrix3<f64>,
    /// What follows.
    pub verdict: Verdict,
}

/// What registration and touch owe to the calibration of the tip, in their covariances too.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TipParts {
    /// What three normal numbers of deviation 1 move the true transform against the registration's by
    /// ([`calib::registration::Propagated::shared`]); `None`: not known, and what its covariance has of it stays in the radius.
    pub registration: Option<Matrix6x3<f64>>,
    /// What they move the touched point by, mm; `None`: not known.
    pub touch: Option<Matrix3<f64>>,
    /// Whether both are by the same numbers: of the same calibration.
    pub same: bool,
}

impl TipParts {
    /// Whether it is known what is left of the tip's error in a check.
    pub fn is_known(&self) -> bool {
        self.same && self.registration.is_some() && self.touch.is_some()
    }
}

/// Holds the touched point, carried by the registration, against the known one. To first order, with the numbers `z` that
/// registration and touch share, the rotation `R`, the place `x` and `J = (-[x]x, I)`:
///
/// ```text
/// error = R (own + U z) - J (own + G z) - known                covariance of the rest + D D^T,   D = R U - J G
/// ```
///
/// What the same tip does to both cancels in `D`, all of it where it was held alike. Where it is not known whether both are of the
/// same calibration, `D` is left out: no relation of the two makes the errors of an unmoved patient smaller, so that what is moved
/// is never let pass for it, and what is not may be refused.
///
/// The prediction assumes that the point was not one of those that the registration was made of.
pub fn check<F: Frame>(
    ct_from: &Uncertain<Ct, F>,
    touched: UncertainPoint<F>,
    known: UncertainPoint<Ct>,
    tip: &TipParts,
    limits: Limits,
) -> Checked {
    let placed = *ct_from * touched;
    let error = placed.point() - known.point();
    let apart = placed.covariance() + known.covariance();
    let covariance = apart - shared_in(ct_from, placed.point(), tip);
    let (distance_mm, radius) = (error.norm(), radius_95_mm(&covariance));
    // What cancels here may add up elsewhere, for a tool that is turned around: a limit is vouched for by the larger.
    let apart_radius_95_mm = radius_95_mm(&apart).max(radius);
    Checked {
        place: placed.point(),
        error,
        distance_mm,
        radius_95_mm: radius,
        apart_radius_95_mm,
        covariance,
        verdict: verdict(distance_mm, [radius, apart_radius_95_mm], limits),
    }
}

/// What the tip's parts of both covariances are more than what is left of them in the error.
fn shared_in<F: Frame>(ct_from: &Uncertain<Ct, F>, place: Point<Ct>, tip: &TipParts) -> Matrix3<f64> {
    let [x, y, z] = place.mm();
    let mut slope = Matrix3x6::zeros();
    slope
        .fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&-nalgebra::Vector3::new(x, y, z).cross_matrix());
    slope.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
    let registration = slope * tip.registration.unwrap_or_default();
    let touch = Matrix3::from(ct_from.transform().rotation().matrix()) * tip.touch.unwrap_or_default();
    let left = match tip.is_known() {
        true => touch - registration,
        false => Matrix3::zeros(),
    };
    registration * registration.transpose() + touch * touch.transpose() - left * left.transpose()
}

fn verdict(distance_mm: f64, [radius_mm, apart_mm]: [f64; 2], limits: Limits) -> Verdict {
    // A NaN is within nothing.
    let within = |limit: f64| distance_mm <= limit;
    let allowed = limits.most_mm.is_none_or(within);
    if !allowed || !within(FAIL_RATIO * radius_mm) {
        return Verdict::Fail;
    }
    let vouched = limits.most_mm.is_none_or(|limit| apart_mm <= limit);
    if vouched && within(radius_mm) {
        Verdict::Pass
    } else {
        Verdict::Warn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use calib::registration::{Method, PairError, Pairs, propagated, register};
    use geometry::{Rigid, Tracker};
    use nalgebra::{Matrix6, Vector3};

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
            assert_eq!(
                verdict(distance, [1.0; 2], limit(most)),
                expected,
                "{distance} {most:?}"
            );
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
        let checked = check(&registration, touched, known, &TipParts::default(), Limits::default());
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

    struct Random(u64);

    impl Random {
        /// Normal, by Box and Muller.
        fn normal(&mut self) -> f64 {
            let mut even = || {
                self.0 ^= self.0 << 13;
                self.0 ^= self.0 >> 7;
                self.0 ^= self.0 << 17;
                ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
            };
            (-2.0 * even().ln()).sqrt() * (std::f64::consts::TAU * even()).cos()
        }

        fn vector(&mut self) -> Vector3<f64> {
            Vector3::from_fn(|_, _| self.normal())
        }
    }

    /// How the tool stands at a touch: its axes in the tracker.
    fn held(random: &mut Random, by_rad: f64) -> Matrix3<f64> {
        *nalgebra::Rotation3::new(random.vector() * by_rad).matrix()
    }

    /// Shares of passes and failures over many operations with a tip calibrated to 0.5 mm along each axis and a hand of 0.2 mm:
    /// six beads, then a check at a place by `moved_mm` off. Errors are drawn, and share nothing with the formulas.
    fn shares(turned_rad: f64, moved_mm: f64, knows: bool, independent: bool) -> [f64; 2] {
        let mut random = Random(0x1234_5678_9abc_def1);
        let truth: Rigid<Ct, Tracker> =
            Rigid::from_rotation_vector(Vector::new(0.4, -0.8, 1.1), Vector::new(40.0, -90.0, 1500.0)).unwrap();
        let (hand_mm, tip_mm) = (0.2, 0.5);
        let at = |x: f64, y: f64, z: f64| truth.inverse() * Point::<Ct>::new(x, y, z);
        let beads = [
            [-60.0, 0.0, 0.0],
            [60.0, 10.0, 0.0],
            [0.0, 70.0, 20.0],
            [10.0, -60.0, 40.0],
            [0.0, 0.0, 80.0],
            [30.0, 30.0, -50.0],
        ]
        .map(|[x, y, z]| at(x, y, z));
        let target = at(20.0, -15.0, 30.0);
        let own = Matrix3::identity() * (hand_mm * hand_mm);
        let (mut passed, mut failed) = (0, 0);
        for _ in 0..TRIALS {
            let z = random.vector();
            // The same tip error in each touch, in the axes of the tool as it is held.
            let touch = |place: Point<Tracker>, random: &mut Random| {
                let shared = held(random, turned_rad) * tip_mm;
                let off = random.vector() * hand_mm + shared * z;
                (place + Vector::new(off.x, off.y, off.z), PairError { own, shared })
            };
            let (touched, errors): (Vec<_>, Vec<_>) = beads.iter().map(|bead| touch(*bead, &mut random)).unzip();
            let (checked_at, error) = touch(target, &mut random);
            let to: Vec<Point<Ct>> = beads.iter().map(|bead| truth * *bead).collect();
            let pairs = Pairs::new(&to, &touched).unwrap();
            let found = register(pairs, Method::default()).unwrap();
            let of = propagated(&found.fit, pairs, &errors).unwrap();
            let registration = Uncertain::new(found.fit.transform, of.covariance).unwrap();
            let touched = UncertainPoint::new(checked_at, error.covariance()).unwrap();
            // To be off is to be another point than the one that was touched.
            let known = UncertainPoint::from(truth * target + Vector::new(0.0, moved_mm, 0.0));
            let tip = match independent {
                true => TipParts {
                    registration: Some(Matrix6x3::zeros()),
                    touch: Some(Matrix3::zeros()),
                    same: true,
                },
                false => TipParts {
                    registration: Some(of.shared),
                    touch: Some(error.shared),
                    same: knows,
                },
            };
            let verdict = check(&registration, touched, known, &tip, Limits::default()).verdict;
            passed += u32::from(verdict == Verdict::Pass);
            failed += u32::from(verdict == Verdict::Fail);
        }
        [passed, failed].map(|count| f64::from(count) / f64::from(TRIALS))
    }

    const TRIALS: u32 = 3000;

    /// The tip's error was counted in registration and touch as if it were two: a marker 2 mm off passed.
    #[test]
    fn an_unmoved_marker_passes_as_stated_and_one_moved_by_2_mm_fails() {
        for turned_rad in [0.0, 0.15, 1.0] {
            let [passed, failed] = shares(turned_rad, 0.0, true, false);
            // 95 of 100, five deviations of a count of 3000; the radius takes no error for smaller than it is.
            assert!((passed - 0.95).abs() < 0.02, "{turned_rad}: {passed}");
            assert!(failed < 0.004, "{turned_rad}: {failed}");
        }
        for turned_rad in [0.0, 0.15] {
            assert!(shares(turned_rad, 2.0, true, false)[1] > 0.97, "{turned_rad}");
        }
        // What it was.
        assert!(shares(0.0, 2.0, true, true)[1] < 0.01);
    }

    /// Where it is not known whether the calibrations are one, moved markers are refused as often, unmoved ones too where the tool is
    /// held otherwise.
    #[test]
    fn what_is_not_known_of_the_tip_makes_the_check_the_stricter() {
        for (turned_rad, moved_mm) in [(0.0, 0.0), (0.0, 2.0), (0.15, 2.0), (1.0, 2.0), (1.0, 0.0)] {
            let [known, unknown] = [true, false].map(|knows| shares(turned_rad, moved_mm, knows, false)[1]);
            assert!(unknown >= known, "{turned_rad} {moved_mm}: {unknown} {known}");
        }
        // Held alike, it all cancels either way.
        assert!((shares(0.0, 0.0, false, false)[0] - 0.95).abs() < 0.02);
    }
}
