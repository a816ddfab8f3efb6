//! Shapes at the edge: spheres that all but hold one another, rods far longer than thick, places far away.

use nalgebra::{Point3, Vector3};

use super::oracle::{Numbers, Shape};

/// Half openings up to `1e-7` short of a right angle: the side is then a strip that hardly exists.
#[test]
fn spheres_that_all_but_hold_one_another() {
    for (seed, short) in [1e-14, 1e-12, 1e-9, 1e-6, 1e-3].into_iter().enumerate() {
        let mut numbers = Numbers::new(seed as u64 + 21);
        for (first, last) in [(1.0, 0.4), (0.4, 1.0)] {
            let pose = numbers.pose(1.0);
            let axis = [Point3::origin(), Point3::new(0.6 * (1.0 + short), 0.0, 0.0)];
            let shape = Shape::new(pose, &axis, &[first, last]);
            for _ in 0..200 {
                let x = numbers.vector() * 3.0;
                let found = shape.tube.signed_distance(&x);
                assert!(
                    (found.value - shape.value(&x)).abs() < 1e-13,
                    "{short}: {} {}",
                    found.value,
                    shape.value(&x)
                );
                assert!((found.gradient.norm() - 1.0).abs() < 1e-13);
                let d = numbers.vector() * 4.0;
                let (searched, clear) = shape.first_touch(&x, &d);
                let touch = shape.tube.first_touch(&x, &d);
                if clear.abs() > 1e-6 {
                    assert_eq!(touch.is_some(), searched.is_some(), "{short}");
                    assert!(
                        touch.zip(searched).is_none_or(|(t, s)| (t - s).abs() < 1e-11),
                        "{short}"
                    );
                }
            }
        }
    }
}

/// A rod a million times longer than thick, or a million times thinner than long: the error is rounding of its length.
#[test]
fn rods_far_longer_than_thick() {
    for (length, radius) in [(1e6, 1.0), (1.0, 1e-6), (1e-6, 1e-12)] {
        let mut numbers = Numbers::new(31);
        let along = numbers.direction();
        let pose = nalgebra::Isometry3::identity();
        let axis = [Point3::origin(), Point3::from(along * length)];
        let shape = Shape::new(pose, &axis, &[radius; 2]);
        for _ in 0..200 {
            let out = along.cross(&numbers.direction()).try_normalize(0.0).unwrap();
            let (part, far) = (0.5 + 0.4 * numbers.next(), radius * (3.0 + 2.0 * numbers.next()));
            let x = along * (part * length) + out * far;
            let found = shape.tube.signed_distance(&x);
            assert!(
                (found.value - (far - radius)).abs() < 4.0 * f64::EPSILON * length,
                "{length} {radius}"
            );
            // Straight at the axis: touched after `far - radius` of `2 far`.
            let touch = shape.tube.first_touch(&x, &(out * (-2.0 * far))).unwrap();
            let expected = (far - radius) / (2.0 * far);
            assert!(
                (touch - expected).abs() < 8.0 * f64::EPSILON * length / far,
                "{length} {radius}: {touch} {expected}"
            );
        }
    }
}

/// From a million radii away: hits and misses are told apart to the rounding of the way, 1e6 times 1e-16 by ten operations.
#[test]
fn ways_from_far_away() {
    let mut numbers = Numbers::new(41);
    for _ in 0..200 {
        let pose = numbers.pose(1.0);
        let shape = Shape::new(pose, &[Point3::origin(), Point3::new(0.0, 0.0, 3.0)], &[1.0; 2]);
        let turn = 3.0 * numbers.next();
        let normal = Vector3::new(turn.cos(), turn.sin(), 0.0);
        // Across the axis, not along it: the way leaves the middle third of the side at once.
        let tangent = (normal.cross(&Vector3::z()) + Vector3::z() * (0.3 * numbers.next()))
            .try_normalize(0.0)
            .unwrap();
        for (off, touches) in [(3e-9, false), (-3e-9, true)] {
            let begin = Vector3::new(0.0, 0.0, 1.5) + normal * (1.0 + off) - tangent * 1e6;
            let begin = pose * Point3::from(begin);
            let touch = shape.tube.first_touch(&begin.coords, &(pose * tangent * 2e6));
            assert_eq!(touch.is_some(), touches);
        }
    }
}
