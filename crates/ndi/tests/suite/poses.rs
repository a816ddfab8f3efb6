//! The door from a transform to a pose.

use ndi::{Pose, PoseError, Transform, UNIT_TOLERANCE, check_place};
use proptest::prelude::*;

use crate::support::transform;

fn refused(change: impl Fn(&mut Transform)) -> PoseError {
    let mut one = transform(1.0);
    change(&mut one);
    one.check(UNIT_TOLERANCE).unwrap_err()
}

#[test]
fn a_good_transform_is_a_pose_with_its_deviation() {
    let pose = transform(1.0).check(UNIT_TOLERANCE).unwrap();
    let expected = Pose {
        q: [0.5, -0.5, 0.5, 0.5],
        t_mm: [1.0, -20.25, -1500.5],
        error_mm: 0.125,
        off_unit: 0.0,
    };
    assert_eq!(pose, expected);
    let mut longer = transform(1.0);
    longer.q = [1.0005, 0.0, 0.0, 0.0];
    assert!((longer.check(1e-3).unwrap().off_unit - 0.0005).abs() < 1e-12);
    assert!(longer.check(1e-4).is_err());
}

#[test]
fn numbers_that_are_none_are_refused_by_name() {
    let not_finite = |field, value| PoseError::NotFinite { field, value };
    assert_eq!(refused(|t| t.q[2] = f64::NAN), not_finite("quaternion", "NaN"));
    assert_eq!(refused(|t| t.t_mm[0] = f64::INFINITY), not_finite("translation", "inf"));
    assert_eq!(refused(|t| t.error_mm = f64::NEG_INFINITY), not_finite("error", "-inf"));
    assert_eq!(refused(|t| t.q = [0.0; 4]), PoseError::ZeroQuaternion);
    assert!(matches!(
        refused(|t| t.q = [1.0, 0.1, 0.0, 0.0]),
        PoseError::NotUnit { .. }
    ));
    assert!(matches!(
        refused(|t| t.error_mm = -0.5),
        PoseError::NegativeError { .. }
    ));
    // What devices write where they know nothing.
    assert!(matches!(
        refused(|t| t.t_mm[1] = -3.697_314e28),
        PoseError::TooFar { .. }
    ));
    assert!(check_place(&[1e5, 0.0, 0.0], "place").is_ok());
}

proptest! {
    #[test]
    fn whatever_comes_is_a_pose_of_unit_length_or_refused(numbers in prop::array::uniform8(any::<u32>())) {
        let [a, b, c, d, x, y, z, error_mm] = numbers.map(|bits| f64::from(f32::from_bits(bits)));
        let one = Transform { q: [a, b, c, d], t_mm: [x, y, z], error_mm };
        if let Ok(pose) = one.check(UNIT_TOLERANCE) {
            let norm = pose.q.iter().map(|x| x * x).sum::<f64>().sqrt();
            prop_assert!((norm - 1.0).abs() <= UNIT_TOLERANCE && pose.t_mm.iter().all(|x| x.abs() <= 1e5));
        }
    }
}
