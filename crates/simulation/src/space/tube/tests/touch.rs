use nalgebra::{Isometry3, Point3, Vector3};

use super::oracle::{Numbers, Shape};
use crate::space::tube::Tube;

#[test]
fn touches_are_those_of_the_search() {
    let (mut touched, mut missed) = (0, 0);
    for size in [1e-6, 1.0, 1e6] {
        for (seed, cones) in (0..30).flat_map(|s| [(s, false), (s, true)]) {
            let mut numbers = Numbers::new(seed + 500);
            let shape = Shape::bent(&mut numbers, size, cones);
            for _ in 0..20 {
                let x = numbers.vector() * (3.0 * size);
                let d = (shape.about(&mut numbers, size) - x) * 1.5;
                let (searched, clear) = shape.first_touch(&x, &d);
                let found = shape.tube.first_touch(&x, &d);
                // Where a segment is missed or grazed by less, the search itself is unsure.
                if clear.abs() < 1e-6 * size {
                    continue;
                }
                match (found, searched) {
                    (Some(f), Some(s)) => {
                        touched += 1;
                        // Rounding of 1e-15 by the slope of the distance on the way: by `clear` above 1e-3.
                        assert!((f - s).abs() < 1e-11, "{size} {seed}: {f} {s}");
                    }
                    (None, None) => missed += 1,
                    both => panic!("{size} {seed} {clear}: {both:?}"),
                }
            }
        }
    }
    assert!(touched > 500 && missed > 500, "{touched} {missed}");
}

/// A way that passes the side, the end, or a round cone at 1e-12 of its radius beyond or within tangency, tube and way turned
/// at will. Rounding: coordinates of 2 radii, ten operations, 4e-15.
#[test]
fn grazing_ways_are_told_apart_to_1e12() {
    let axis = [Point3::origin(), Point3::new(0.0, 0.0, 3.0)];
    for (seed, radii) in (0..200).flat_map(|s| [(s, [1.0; 2]), (s, [1.0, 0.6]), (s, [1.0, 1.0 - 1e-9])]) {
        let mut numbers = Numbers::new(seed + 900);
        let pose = numbers.pose(1.0);
        let tube = Tube::new(pose, &axis, &radii).unwrap();
        // A place of the surface by its normal: on the side, and on the sphere of the first end.
        let sine = (radii[0] - radii[1]) / 3.0;
        let turn = 3.0 * numbers.next();
        let normal =
            Vector3::new(turn.cos(), turn.sin(), 0.0) * ((1.0 - sine) * (1.0 + sine)).sqrt() + Vector3::z() * sine;
        let (t, around) = (1.5 + 1.4 * numbers.next(), numbers.direction());
        let below = Vector3::new(around.x, around.y, -around.z.abs() - 0.1)
            .try_normalize(0.0)
            .unwrap();
        let side = (Vector3::z() * t, radii[0] - sine * t, normal);
        let ball = (Vector3::zeros(), radii[0], below);
        for (centre, radius, normal) in [side, ball] {
            let tangent = normal.cross(&numbers.direction()).try_normalize(0.0).unwrap();
            for (off, touches) in [(1e-12, false), (-1e-12, true)] {
                let middle = centre + normal * (radius + off);
                let begin = pose * Point3::from(middle - tangent * 1.7);
                let found = tube.first_touch(&begin.coords, &(pose * tangent * 3.0));
                assert_eq!(found.is_some(), touches, "{seed} {radii:?} {off}");
                // Half a chord of depth 1e-12 in a curve of radius 2 at most, in a cone as long as 1e-5 by its least curvature.
                assert!(found.is_none_or(|t| (t - 1.7 / 3.0).abs() < 1e-4), "{found:?}");
            }
        }
    }
}

/// Along the axis of a side: parallel ways within, on and beyond the surface.
#[test]
fn ways_parallel_to_the_axis_meet_the_end_or_nothing() {
    let tube = Tube::straight(Point3::origin(), Vector3::z(), 2.0, 1.0).unwrap();
    let from = |rho: f64| tube.first_touch(&Vector3::new(rho, 0.0, -3.0), &Vector3::new(0.0, 0.0, 6.0));
    assert!((from(0.0).unwrap() - 2.0 / 6.0).abs() < 1e-15);
    assert!((from(0.6).unwrap() - 2.2 / 6.0).abs() < 1e-15);
    assert!(from(1.0 - 1e-12).is_some_and(|t| (t - 0.5).abs() < 1e-5));
    assert_eq!(from(1.0 + 1e-12), None);
}

#[test]
fn inside_and_on_the_surface_the_touch_is_at_once() {
    let tube = Tube::straight(Point3::origin(), Vector3::z(), 2.0, 1.0).unwrap();
    for d in [Vector3::x(), -Vector3::x(), Vector3::zeros()] {
        assert_eq!(tube.first_touch(&Vector3::new(0.3, 0.0, 1.0), &d), Some(0.0));
        assert_eq!(tube.first_touch(&Vector3::new(1.0, 0.0, 1.0), &d), Some(0.0));
    }
    let beside = Vector3::new(1.0 + 1e-12, 0.0, 1.0);
    assert_eq!(tube.first_touch(&beside, &Vector3::zeros()), None);
    assert_eq!(tube.first_touch(&beside, &Vector3::x()), None);
    // The way left is 1e-12 +- 2e-16.
    let touch = tube.first_touch(&beside, &-Vector3::x()).unwrap();
    assert!((touch - 1e-12).abs() < 1e-15, "{touch:e}");
}

/// The end of the way counts, what lies beyond does not.
#[test]
fn the_way_ends_at_its_end() {
    let tube = Tube::straight(Point3::origin(), Vector3::z(), 2.0, 1.0).unwrap();
    let from = Vector3::new(3.0, 0.0, 1.0);
    assert!((tube.first_touch(&from, &Vector3::new(-2.0 - 1e-12, 0.0, 0.0)).unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(tube.first_touch(&from, &Vector3::new(-2.0 + 1e-12, 0.0, 0.0)), None);
    assert_eq!(tube.first_touch(&from, &Vector3::new(2.0, 0.0, 0.0)), None);
}

/// A cone's form has a mirrored twin behind its apex, and an inside beyond its ends: neither is the tube.
#[test]
fn the_mirrored_cone_is_not_touched() {
    let axis = [Point3::origin(), Point3::new(0.0, 0.0, 4.0)];
    let tube = Tube::new(Isometry3::identity(), &axis, &[3.0, 1.0]).unwrap();
    // The apex is at z = 6: a way across the twin alone, and one from within the twin that goes on to the tube's end.
    assert_eq!(
        tube.first_touch(&Vector3::new(-9.0, 0.0, 9.0), &Vector3::new(18.0, 0.0, 0.0)),
        None
    );
    let down = tube
        .first_touch(&Vector3::new(0.0, 0.0, 10.0), &Vector3::new(0.0, 0.0, -10.0))
        .unwrap();
    assert!((down - 0.5).abs() < 1e-15);
    // From within the twin, steeply, onto the side: x = 3, where the side is at z = 6 - 3 sqrt 3 or so.
    let (x, d) = (Vector3::new(2.4, 0.0, 14.0), Vector3::new(0.0, 0.0, -14.0));
    let touch = tube.first_touch(&x, &d).unwrap();
    let value = tube.signed_distance(&(x + d * touch)).value;
    assert!(value.abs() < 1e-13, "{touch} {value}");
    let before = tube.signed_distance(&(x + d * (touch - 1e-6))).value;
    assert!(before > 0.0);
}

/// The tube of one point is a sphere.
#[test]
fn a_sphere_is_touched_in_closed_form() {
    let mut numbers = Numbers::new(77);
    for _ in 0..200 {
        let pose = numbers.pose(1.0);
        let shape = Shape::new(pose, &[Point3::origin()], &[0.4]);
        let centre = pose.translation.vector;
        let (out, off) = (numbers.direction(), 0.3 * numbers.next());
        let aside = out.cross(&numbers.direction()).try_normalize(0.0).unwrap();
        let x = centre + out * 2.0 + aside * off;
        let expected = (2.0 - (0.16 - off * off).sqrt()) / 3.0;
        let found = shape.tube.first_touch(&x, &(-out * 3.0)).unwrap();
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }
}
