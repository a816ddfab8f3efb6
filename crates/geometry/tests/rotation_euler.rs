//! Euler angles in all conventions, near and at their locks.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test stops where it cannot go on, and prints what it measured or why it was skipped"
)]

use std::f64::consts::{FRAC_PI_2, PI};

use geometry::rotation::{Axis, Euler, EulerAngles, Frames, Rotation, RotationVector};
use proptest::prelude::*;

const ULP: f64 = f64::EPSILON;

fn turn(w: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(w).unwrap())
}

fn norm(v: impl IntoIterator<Item = f64>) -> f64 {
    v.into_iter().fold(0.0, f64::hypot)
}

/// The distance of two vectors relative to the second.
fn off<const N: usize>(got: [f64; N], want: [f64; N]) -> f64 {
    norm((0..N).map(|i| got[i] - want[i])) / norm(want)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn all_euler_angles_come_back(w in prop::array::uniform3(-3.5..3.5)) {
        for convention in Euler::all() {
            let angles = turn(w).euler(convention);
            // The bound stated: 8 ulp, and 4 of the distance itself.
            prop_assert!(angles.rotation().unwrap().distance(turn(w)) <= 12.0 * ULP, "{angles:?}");
            prop_assert!(angles.radians.iter().all(|a| a.abs() <= PI));
        }
    }

    #[test]
    fn locked_euler_angles_give_the_rotation_back(a in -3.0..3.0f64, b in -3.0..3.0f64, e in -60.0..0.0f64) {
        for convention in Euler::all() {
            for middle in [0.0, FRAC_PI_2, -FRAC_PI_2, PI] {
                let near = EulerAngles { convention, radians: [a, middle + 2f64.powf(e), b] }.rotation().unwrap();
                let angles = near.euler(convention);
                prop_assert!(angles.rotation().unwrap().distance(near) <= 12.0 * ULP, "{angles:?}");
            }
        }
    }

    #[test]
    fn small_euler_angles_keep_their_digits(a in prop::array::uniform3(-1.0..1.0), e in -900..0) {
        for convention in Euler::all() {
            let radians = a.map(|x: f64| x * 2f64.powi(e));
            let angles = EulerAngles { convention, radians };
            let back = angles.rotation().unwrap().euler(convention);
            // Those with two equal axes are locked at the identity; 8 ulp and the amplification 1/cos(1) of the others.
            let locked = format!("{convention:?}");
            let count = |axis: &str| locked.matches(axis).count();
            if ["X", "Y", "Z"].iter().all(|axis| count(axis) == 1) {
                prop_assert!(off(back.radians, radians) <= 16.0 * ULP, "{angles:?} {back:?}");
            }
        }
    }
}

#[test]
fn there_are_24_conventions() {
    assert_eq!(Euler::all().count(), 24);
}

#[test]
fn the_order_of_the_turns() {
    let [a, b, c] = [0.3, -0.5, 0.7];
    let (x, y, z) = (
        |t| turn([t, 0.0, 0.0]),
        |t| turn([0.0, t, 0.0]),
        |t| turn([0.0, 0.0, t]),
    );
    let rotation = |axes, frames| {
        let convention = Euler::new(axes, frames).unwrap();
        let radians = [a, b, c];
        EulerAngles { convention, radians }.rotation().unwrap()
    };
    let xyz = [Axis::X, Axis::Y, Axis::Z];
    let zxz = [Axis::Z, Axis::X, Axis::Z];
    // Two products of 4 ulp each on both sides.
    assert!(rotation(xyz, Frames::Static).distance(z(c) * y(b) * x(a)) <= 16.0 * ULP);
    assert!(rotation(xyz, Frames::Rotating).distance(x(a) * y(b) * z(c)) <= 16.0 * ULP);
    assert!(rotation(zxz, Frames::Static).distance(z(c) * x(b) * z(a)) <= 16.0 * ULP);
    assert!(rotation(zxz, Frames::Rotating).distance(z(a) * x(b) * z(c)) <= 16.0 * ULP);
    assert_eq!(Euler::new([Axis::X, Axis::X, Axis::Z], Frames::Static), None);
}

#[test]
fn at_the_lock_the_last_turn_is_none() {
    for convention in Euler::all() {
        for middle in [0.0, FRAC_PI_2, PI, -FRAC_PI_2] {
            let radians = [0.4, middle, 0.9];
            let angles = EulerAngles { convention, radians }
                .rotation()
                .unwrap()
                .euler(convention);
            let three = format!("{convention:?}");
            let different = ["X", "Y", "Z"].iter().all(|axis| three.contains(axis));
            let locked = if different {
                middle.abs() == FRAC_PI_2
            } else {
                middle == 0.0 || middle == PI
            };
            // 2 ulp of pi where the sum or difference goes round.
            assert_eq!(locked, angles.radians[2].abs() <= 4.0 * ULP, "{angles:?}");
        }
    }
}
