use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::oracle::{Numbers, Shape};
use crate::space::tube::{Distance, Tube};

const SIZES: [f64; 3] = [1e-6, 1.0, 1e6];

/// Values against the search: both are sums of about ten terms of at most 4 sizes, so 40 roundings of that.
#[test]
fn values_are_those_of_the_search() {
    for size in SIZES {
        for (seed, cones) in (0..40).flat_map(|s| [(s, false), (s, true)]) {
            let mut numbers = Numbers::new(seed + 1);
            let shape = Shape::bent(&mut numbers, size, cones);
            for _ in 0..20 {
                let x = numbers.vector() * (3.0 * size);
                let (found, searched) = (shape.tube.signed_distance(&x).value, shape.value(&x));
                // The value alone, within the same bound.
                let alone = shape.tube.distance(&x);
                assert!(
                    (alone - searched).abs() < 160.0 * f64::EPSILON * size,
                    "{size} {seed}: {alone}"
                );
                assert!(
                    (found - searched).abs() < 160.0 * f64::EPSILON * size,
                    "{size} {seed}: {found} {searched}"
                );
            }
        }
    }
}

#[test]
fn closed_forms_of_a_straight_tube() {
    let tube = Tube::straight(Point3::new(1.0, 2.0, 3.0), Vector3::z(), 10.0, 0.5).unwrap();
    let beside = tube.signed_distance(&Vector3::new(4.0, 6.0, 7.0));
    assert!((beside.value - 4.5).abs() < 1e-14);
    assert!((beside.gradient - Vector3::new(0.6, 0.8, 0.0)).norm() < 1e-14);
    let around = Vector3::new(-0.8, 0.6, 0.0);
    assert!((beside.hessian - around * around.transpose() / 5.0).norm() < 1e-14);
    let below = tube.signed_distance(&Vector3::new(1.0, 2.0, -1.0));
    assert!((below.value - 3.5).abs() < 1e-14);
    assert!((below.gradient + Vector3::z()).norm() < 1e-14);
    let flat = Matrix3::from_diagonal(&Vector3::new(0.25, 0.25, 0.0));
    assert!((below.hessian - flat).norm() < 1e-14);
    assert!((tube.signed_distance(&Vector3::new(1.3, 2.0, 5.0)).value + 0.2).abs() < 1e-14);
}

/// Radius 3 at the origin to 1 at z = 4: sine 1/2. A place a way `h` out along the side's normal is `h` away.
#[test]
fn closed_form_of_a_round_cone() {
    let axis = [Point3::origin(), Point3::new(0.0, 0.0, 4.0)];
    let tube = Tube::new(Isometry3::identity(), &axis, &[3.0, 1.0]).unwrap();
    let normal = Vector3::new(0.75_f64.sqrt(), 0.0, 0.5);
    for (along, out) in [(0.1, 1.0), (0.5, 0.0), (0.5, -0.7), (0.9, 20.0)] {
        let radius = 3.0 - 2.0 * along;
        let x = Vector3::new(0.0, 0.0, 4.0 * along) + normal * (radius + out);
        let found = tube.signed_distance(&x);
        assert!((found.value - out).abs() < 1e-13, "{along} {out}: {}", found.value);
        assert!((found.gradient - normal).norm() < 1e-13);
        // Around the axis only, by the distance along the normal to it.
        let curved = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0 / (radius + out), 0.0));
        assert!((found.hessian - curved).norm() < 1e-13);
    }
}

/// Derivatives by central differences of `h = 1e-4` radii: truncation `h^2 / 6` times a third derivative of at most 6 by the
/// square of the distance to the axis, here above 1/4 of the radius: 2e-7 at most; rounding `1e-15 / 1e-4`.
#[test]
fn derivatives_are_those_of_differences() {
    let mut compared = 0;
    for size in SIZES {
        for (seed, cones) in (0..30).flat_map(|s| [(s, false), (s, true)]) {
            let mut numbers = Numbers::new(seed + 100);
            let shape = Shape::bent(&mut numbers, size, cones);
            for _ in 0..20 {
                let x = numbers.vector() * (2.0 * size);
                compared += u32::from(compare(&shape.tube, &x, size));
            }
        }
    }
    // Places beside a seam are left to the tests of seams; they must not be the rule.
    assert!(compared > 3000, "{compared}");
}

/// Whether all places of the differences lie on one smooth piece; they are then compared.
fn compare(tube: &Tube, x: &Vector3<f64>, size: f64) -> bool {
    let h = 2e-5 * size;
    let here = tube.signed_distance(x);
    let near = |i: usize, s: f64| tube.signed_distance(&(x + Vector3::ith(i, s * h)));
    let pairs = [0, 1, 2].map(|i| [near(i, 1.0), near(i, -1.0)]);
    let smooth =
        |d: &Distance| (d.hessian - here.hessian).norm() * size < 1e-2 && (d.gradient - here.gradient).norm() < 1e-2;
    if here.value < -0.1 * size || !pairs.iter().flatten().all(smooth) {
        return false;
    }
    for (i, [up, down]) in pairs.iter().enumerate() {
        let slope = (up.value - down.value) / (2.0 * h);
        assert!((slope - here.gradient[i]).abs() < 1e-7, "{slope} {}", here.gradient[i]);
        let bend = (up.gradient - down.gradient) / (2.0 * h) * size;
        let column = here.hessian.column(i) * size;
        assert!(
            (bend - column).norm() < 1e-6 * column.norm().max(1.0),
            "{bend} {column}"
        );
    }
    true
}

#[test]
fn normals_have_length_one_and_do_not_bend_along_themselves() {
    let mut numbers = Numbers::new(7);
    for cones in [false, true] {
        let shape = Shape::bent(&mut numbers, 1.0, cones);
        for _ in 0..2000 {
            let found = shape.tube.signed_distance(&(numbers.vector() * 3.0));
            assert!((found.gradient.norm() - 1.0).abs() < 1e-14);
            assert!((found.hessian * found.gradient).norm() < 1e-13 * found.hessian.norm());
            assert!((found.hessian - found.hessian.transpose()).norm() < 1e-14 * found.hessian.norm());
        }
    }
}

/// No two places differ by more than the way between them, across every seam, inside and out.
#[test]
fn the_value_never_changes_faster_than_the_way() {
    let mut numbers = Numbers::new(11);
    for cones in [false, true] {
        let shape = Shape::bent(&mut numbers, 1.0, cones);
        for _ in 0..5000 {
            let (x, step) = (numbers.vector() * 1.5, numbers.vector() * 0.1);
            let [a, b] = [x, x + step].map(|p| shape.tube.signed_distance(&p).value);
            assert!((a - b).abs() <= step.norm() + 40.0 * f64::EPSILON);
        }
    }
}

#[test]
fn a_segment_without_length_or_within_its_sphere_is_a_sphere() {
    let mut numbers = Numbers::new(13);
    for size in SIZES {
        let centre = Point3::new(0.3, -0.2, 0.7) * size;
        let ball = Tube::new(Isometry3::identity(), &[centre], &[size]).unwrap();
        let beside = centre + Vector3::new(0.1, 0.2, 0.0) * size;
        let same = [
            Tube::new(Isometry3::identity(), &[centre; 3], &[size; 3]).unwrap(),
            Tube::new(Isometry3::identity(), &[centre, beside], &[size, 0.5 * size]).unwrap(),
            Tube::new(Isometry3::identity(), &[beside, centre], &[0.5 * size, size]).unwrap(),
        ];
        for _ in 0..100 {
            let (x, d) = (numbers.vector() * (3.0 * size), numbers.vector() * (3.0 * size));
            let out = (x - centre.coords).norm() - size;
            assert!((ball.signed_distance(&x).value - out).abs() < 8.0 * f64::EPSILON * size);
            for tube in &same {
                assert_eq!(tube.signed_distance(&x), ball.signed_distance(&x));
                assert_eq!(tube.first_touch(&x, &d), ball.first_touch(&x, &d));
            }
        }
    }
}
