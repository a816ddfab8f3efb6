use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::space::tube::{Sweep, SweepError, Tube, TubeError};

fn ball() -> Tube {
    Tube::new(Isometry3::identity(), &[Point3::origin()], &[1.0]).unwrap()
}

#[test]
fn axes_and_radii_are_refused_by_name() {
    let make = |axis: &[Point3<f64>], radii: &[f64]| Tube::new(Isometry3::identity(), axis, radii).unwrap_err();
    let origin = Point3::origin();
    assert_eq!(make(&[], &[]), TubeError::NoPoints);
    assert_eq!(make(&[], &[1.0]), TubeError::NoPoints);
    assert_eq!(make(&[origin; 2], &[1.0]), TubeError::Count { points: 2, radii: 1 });
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(
            make(&[origin, Point3::new(0.0, bad, 0.0)], &[1.0; 2]),
            TubeError::Point { index: 1 }
        );
    }
    for bad in [0.0, -0.0, -1.0, f64::INFINITY] {
        assert_eq!(
            make(&[origin; 2], &[1.0, bad]),
            TubeError::Radius { index: 1, radius: bad }
        );
    }
    let nan = make(&[origin], &[f64::NAN]);
    assert!(matches!(nan, TubeError::Radius { index: 0, radius } if radius.is_nan()));
    assert!(nan.to_string().contains("radius 0 is NaN"));
}

#[test]
fn straight_tubes_need_a_direction_and_a_length() {
    let make = |direction, length| Tube::straight(Point3::origin(), direction, length, 1.0).unwrap_err();
    for direction in [
        Vector3::zeros(),
        Vector3::new(f64::NAN, 0.0, 0.0),
        Vector3::new(0.0, f64::INFINITY, 0.0),
    ] {
        assert_eq!(make(direction, 1.0), TubeError::Point { index: 1 });
    }
    for length in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(make(Vector3::x(), length), TubeError::Point { index: 1 });
    }
    assert_eq!(
        Tube::straight(Point3::new(0.0, f64::NAN, 0.0), Vector3::x(), 1.0, 1.0).unwrap_err(),
        TubeError::Pose
    );
}

#[test]
fn poses_are_refused() {
    let lost = Isometry3::translation(0.0, f64::NAN, 0.0);
    let turned = UnitQuaternion::from_scaled_axis(Vector3::new(f64::NAN, 0.0, 0.0));
    let turned = Isometry3::from_parts(Translation3::identity(), turned);
    for pose in [lost, turned] {
        assert_eq!(
            Tube::new(pose, &[Point3::origin()], &[1.0]).unwrap_err(),
            TubeError::Pose
        );
        assert_eq!(ball().at(pose).unwrap_err(), TubeError::Pose);
        assert_eq!(Sweep::new(ball(), pose).unwrap_err(), TubeError::Pose);
    }
    let sweep = Sweep::new(ball(), Isometry3::translation(1.0, 0.0, 0.0)).unwrap();
    assert_eq!(sweep.tube(f64::NAN).unwrap_err(), TubeError::Pose);
}

#[test]
fn sweeps_refuse_numbers_and_say_when_they_give_up() {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * 3.0);
    let around = Isometry3::from_parts(Translation3::identity(), turn);
    let sweep = Sweep::new(ball(), around).unwrap();
    let (x, d) = (Vector3::x() * 5.0, Vector3::y());
    let (nan, endless) = (Vector3::new(f64::NAN, 0.0, 0.0), Vector3::new(0.0, f64::INFINITY, 0.0));
    assert_eq!(sweep.first_touch(&nan, &d, 1e-6), Err(SweepError::Number));
    assert_eq!(sweep.first_touch(&x, &endless, 1e-6), Err(SweepError::Number));
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(sweep.first_touch(&x, &d, tolerance), Err(SweepError::Number));
    }
    // A ball that turns on the spot, a point that rests a hair off it: each step may only be as long as the gap allows.
    let beside = Vector3::x() * (1.0 + 1e-13);
    let undecided = sweep.first_touch(&beside, &Vector3::zeros(), 1e-15);
    assert!(matches!(undecided, Err(SweepError::Undecided { free_until }) if free_until > 0.0 && free_until < 1.0));
}

/// A place that is not finite gives NaN, never a number that could be taken for a distance, and no touch.
#[test]
fn places_that_are_not_finite_have_no_distance() {
    let nan = Vector3::new(f64::NAN, 0.0, 0.0);
    assert!(ball().signed_distance(&nan).value.is_nan());
    assert_eq!(ball().first_touch(&nan, &Vector3::x()), None);
    assert_eq!(ball().first_touch(&(Vector3::x() * 3.0), &nan), None);
}
