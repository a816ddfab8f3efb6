//! Numbers that are no rotations, and means that do not exist, are refused by name.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test stops where it cannot go on, and prints what it measured or why it was skipped"
)]

use std::f64::consts::PI;

use geometry::rotation::{
    AxisAngle, Rotation, RotationError, RotationMatrix, RotationVector, chordal_mean, geodesic_mean,
};

fn turn(w: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(w).unwrap())
}

#[test]
fn bad_numbers_are_refused_by_name() {
    use RotationError as E;
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    assert_eq!(
        Rotation::from_quaternion([1.0, nan, 0.0, 0.0]),
        Err(E::Nan {
            what: "quaternion",
            index: 1
        })
    );
    assert_eq!(
        Rotation::from_quaternion([1.0, 0.0, 0.0, -inf]),
        Err(E::Infinite {
            what: "quaternion",
            index: 3
        })
    );
    assert_eq!(Rotation::from_quaternion([0.0; 4]), Err(E::Zero { what: "quaternion" }));
    assert_eq!(
        RotationVector::new([inf, 0.0, 0.0]),
        Err(E::Infinite {
            what: "rotation vector",
            index: 0
        })
    );
    assert_eq!(AxisAngle::new([0.0, -0.0, 0.0], 1.0), Err(E::Zero { what: "axis" }));
    assert_eq!(
        AxisAngle::new([1.0, 0.0, 0.0], nan),
        Err(E::Nan {
            what: "angle",
            index: 0
        })
    );
    let mirror = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    assert_eq!(
        RotationMatrix::new(mirror, 1e-3),
        Err(E::Reflection { determinant: -1.0 })
    );
    let flat = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]];
    assert!(matches!(RotationMatrix::nearest(flat), Err(E::Singular { .. })));
    assert!(matches!(
        RotationMatrix::nearest([[0.0; 3]; 3]),
        Err(E::Singular { .. })
    ));
    assert!(matches!(
        RotationMatrix::nearest([[0.0, 0.0, nan]; 3]),
        Err(E::Nan { index: 2, .. })
    ));
    let tracker = [[1.0005, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let refused = RotationMatrix::new(tracker, 1e-4).unwrap_err();
    assert!(refused.to_string().contains("nearest rotation"), "{refused}");
    assert_eq!(RotationMatrix::new(tracker, 1e-3).unwrap().rows()[0], [1.0, 0.0, 0.0]);
}

#[test]
fn means_that_do_not_exist_are_refused() {
    use RotationError as E;
    let r = Rotation::IDENTITY;
    let half = turn([PI, 0.0, 0.0]);
    assert_eq!(
        chordal_mean(&[], &[]),
        Err(E::Count {
            rotations: 0,
            weights: 0
        })
    );
    assert_eq!(
        chordal_mean(&[r], &[1.0, 2.0]),
        Err(E::Count {
            rotations: 1,
            weights: 2
        })
    );
    assert_eq!(chordal_mean(&[r, r], &[1.0, -2.0]), Err(E::Weight { index: 1 }));
    assert_eq!(chordal_mean(&[r], &[0.0]), Err(E::Weight { index: 0 }));
    assert_eq!(geodesic_mean(&[r, half], &[1.0, 1.0]), Err(E::NoMean));
    assert_eq!(
        chordal_mean(&[r], &[f64::NAN]),
        Err(E::Nan {
            what: "weights",
            index: 0
        })
    );
}
