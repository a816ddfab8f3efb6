use std::f64::consts::PI;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::oracle::{Numbers, Shape};
use crate::space::tube::{Sweep, Tube};

fn turned(axis: Vector3<f64>, way: Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(way), UnitQuaternion::from_scaled_axis(axis))
}

fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    let turn = a.rotation.to_rotation_matrix().matrix() - b.rotation.to_rotation_matrix().matrix();
    (a.translation.vector - b.translation.vector).norm() + turn.norm()
}

/// Both ends are met for turns from none to a half, across the angle where series take over.
#[test]
fn a_sweep_begins_and_ends_at_its_poses() {
    let mut numbers = Numbers::new(1);
    for angle in [
        0.0,
        1e-300,
        1e-12,
        1e-8,
        0.99e-4,
        1.01e-4,
        1e-2,
        1.0,
        3.0,
        PI - 1e-9,
        PI,
    ] {
        for _ in 0..20 {
            let from = numbers.pose(1.0);
            let turn = UnitQuaternion::from_scaled_axis(numbers.direction() * angle);
            let to = Isometry3::from_parts(Translation3::from(numbers.vector()), turn * from.rotation);
            let tube = Tube::new(from, &[Point3::origin()], &[1.0]).unwrap();
            let sweep = Sweep::new(tube, to).unwrap();
            assert!(apart(&sweep.pose(0.0), &from) < 1e-14);
            assert!(apart(&sweep.pose(1.0), &to) < 1e-13, "{angle}");
        }
    }
}

/// A steady twist: the relative motion of every tenth is the same, and a place of it moves in a circle about its axis.
#[test]
fn the_twist_is_steady() {
    let mut numbers = Numbers::new(2);
    for _ in 0..50 {
        let (from, to) = (numbers.pose(1.0), numbers.pose(1.0));
        let tube = Tube::new(from, &[Point3::origin()], &[1.0]).unwrap();
        let sweep = Sweep::new(tube, to).unwrap();
        let part = sweep.pose(0.1) * from.inverse();
        for tenth in 1..10 {
            let time = f64::from(tenth) / 10.0;
            let next = part * sweep.pose(time);
            assert!(apart(&next, &sweep.pose(time + 0.1)) < 1e-13);
        }
    }
}

/// Without a turn the answer is the closed form of the relative way.
#[test]
fn a_slide_alone_is_the_relative_way() {
    let mut numbers = Numbers::new(3);
    let mut touched = 0;
    for seed in 0..200 {
        let shape = Shape::bent(&mut Numbers::new(seed), 1.0, seed % 2 == 0);
        let way = numbers.vector() * 3.0;
        let to = Translation3::from(way) * shape.tube.pose();
        let x = numbers.vector() * 3.0;
        let d = (shape.about(&mut numbers, 1.0) - x) * 1.5 + way;
        let sweep = Sweep::new(shape.tube.clone(), to).unwrap();
        let (found, expected) = (
            sweep.first_touch(&x, &d, 1e-12).unwrap(),
            shape.tube.first_touch(&x, &(d - way)),
        );
        assert_eq!(found.is_some(), expected.is_some(), "{seed}");
        if let (Some(f), Some(e)) = (found, expected) {
            touched += 1;
            // Rounding and tolerance, by the slope on the way.
            assert!((f - e).abs() < 1e-9, "{seed}: {f} {e}");
        }
    }
    assert!(touched > 30, "{touched}");
}

/// A rod of radius 0.1 along x turns about z by half a turn; a point at distance 2 is met when the rod's side is there:
/// at the angle of the point less `asin(0.1 / 2)`.
#[test]
fn a_turning_rod_meets_a_resting_point() {
    let tube = Tube::straight(Point3::origin(), Vector3::x(), 3.0, 0.1).unwrap();
    let sweep = Sweep::new(tube, turned(Vector3::z() * 3.0, Vector3::zeros())).unwrap();
    for angle in [0.3, 1.0, 2.0, 2.9] {
        let x = Vector3::new(2.0 * f64::cos(angle), 2.0 * f64::sin(angle), 0.0);
        let found = sweep.first_touch(&x, &Vector3::zeros(), 1e-10).unwrap().unwrap();
        let expected = (angle - f64::asin(0.05)) / 3.0;
        // The tolerance is passed at 6 lengths by unit of time.
        assert!(
            found <= expected + 1e-15 && expected - found < 1e-10,
            "{angle}: {found} {expected}"
        );
    }
    // Beyond the end of the turn, out of reach, and carried along with the rod itself.
    for x in [
        Vector3::new(2.0 * f64::cos(3.1), 2.0 * f64::sin(3.1), 0.0),
        Vector3::new(0.0, 3.11, 0.0),
    ] {
        assert_eq!(sweep.first_touch(&x, &Vector3::zeros(), 1e-10).unwrap(), None);
    }
}

/// A thin rod that jumps across a point within one step is not missed, nor is a point that jumps across the rod.
#[test]
fn nothing_is_tunnelled_through() {
    let tube = Tube::straight(Point3::origin(), Vector3::x(), 3.0, 1e-6).unwrap();
    let sweep = Sweep::new(tube, turned(Vector3::z() * 3.0, Vector3::zeros())).unwrap();
    let mut numbers = Numbers::new(4);
    for _ in 0..100 {
        let angle = 1.5 + 1.4 * numbers.next();
        let x = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0) * (1.6 + numbers.next());
        assert!(sweep.first_touch(&x, &Vector3::zeros(), 1e-9).unwrap().is_some());
    }
}

/// Random twists against samples: no touch before the time given, within the tolerance at it, none missed by a sample.
#[test]
fn the_time_given_is_never_late() {
    let tolerance = 1e-7;
    let (mut touched, mut free) = (0, 0);
    for seed in 0..200 {
        let mut numbers = Numbers::new(seed + 40);
        let shape = Shape::bent(&mut numbers, 1.0, seed % 2 == 0);
        let to = numbers.pose(1.0);
        let sweep = Sweep::new(shape.tube.clone(), to).unwrap();
        let x = numbers.vector() * 3.0;
        let d = (shape.about(&mut numbers, 1.0) - x) * 1.5;
        let value = |t: f64| sweep.tube(t).unwrap().signed_distance(&(x + d * t)).value;
        let found = sweep.first_touch(&x, &d, tolerance).unwrap();
        if value(0.0) <= tolerance {
            assert_eq!(found, Some(0.0));
            continue;
        }
        let until = found.unwrap_or(1.0);
        for i in 0..400 {
            assert!(value(until * f64::from(i) / 400.0) > 0.0, "{seed}");
        }
        if found.is_some() {
            touched += 1;
            assert!(value(until).abs() < tolerance + 1e-14, "{seed}: {}", value(until));
        } else {
            free += 1;
        }
    }
    assert!(touched > 20 && free > 20, "{touched} {free}");
}
