//! Places planted on and beside the seams: the ends of a segment, its axis, the tie of two segments.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::oracle::Numbers;
use crate::space::tube::{Distance, Tube};

const BESIDE: [f64; 7] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3];

fn posed(axis: &[Point3<f64>], radii: &[f64], seed: u64) -> (Tube, Isometry3<f64>) {
    let pose = Numbers::new(seed).pose(1.0);
    (Tube::new(pose, axis, radii).unwrap(), pose)
}

/// What the posed tube says of a place of its own frame, seen from that frame.
fn seen(tube: &Tube, pose: &Isometry3<f64>, x: Vector3<f64>) -> Distance {
    let found = tube.signed_distance(&(pose * Point3::from(x)).coords);
    let turn = pose.rotation.to_rotation_matrix();
    Distance {
        value: found.value,
        gradient: turn.inverse() * found.gradient,
        hessian: turn.matrix().transpose() * found.hessian * turn.matrix(),
    }
}

/// Beside the end of a capsule: before the end's plane it curves once, beyond it twice; value and normal do not jump.
#[test]
fn the_side_ends_and_the_sphere_begins() {
    let end = [Point3::origin(), Point3::new(0.0, 0.0, 4.0)];
    let (tube, pose) = posed(&end, &[0.5; 2], 3);
    for rho in [0.51, 1.0, 40.0] {
        for beside in BESIDE {
            let side = seen(&tube, &pose, Vector3::new(rho, 0.0, 4.0 - beside));
            let around = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0 / rho, 0.0));
            assert!((side.value - (rho - 0.5)).abs() < 1e-13);
            assert!((side.gradient - Vector3::x()).norm() < 1e-14);
            assert!((side.hessian - around).norm() < 1e-12, "{rho} {beside}");

            let ball = seen(&tube, &pose, Vector3::new(rho, 0.0, 4.0 + beside));
            let far = rho.hypot(beside);
            let out = Vector3::new(rho, 0.0, beside) / far;
            let twice = (Matrix3::identity() - out * out.transpose()) / far;
            assert!((ball.value - (far - 0.5)).abs() < 1e-13);
            assert!((ball.gradient - out).norm() < 1e-13);
            assert!((ball.hessian - twice).norm() < 1e-12, "{rho} {beside}");
        }
    }
}

/// On the end itself, without a pose so that the foot is exactly there: the sphere answers.
#[test]
fn on_the_end_itself_the_sphere_answers() {
    let axis = [Point3::origin(), Point3::new(0.0, 0.0, 4.0)];
    let tube = Tube::new(Isometry3::identity(), &axis, &[0.5; 2]).unwrap();
    for z in [0.0, 4.0] {
        let found = tube.signed_distance(&Vector3::new(2.0, 0.0, z));
        assert_eq!(found.hessian, Matrix3::from_diagonal(&Vector3::new(0.0, 0.5, 0.5)));
    }
}

/// The seam of a round cone is tilted: it leaves the end along the side's normal.
#[test]
fn the_seam_of_a_round_cone_is_tilted() {
    let axis = [Point3::origin(), Point3::new(0.0, 0.0, 4.0)];
    let (tube, pose) = posed(&axis, &[3.0, 1.0], 5);
    let (normal, down) = (
        Vector3::new(0.75_f64.sqrt(), 0.0, 0.5),
        Vector3::new(0.5, 0.0, -0.75_f64.sqrt()),
    );
    for beside in BESIDE {
        let seam = Vector3::new(0.0, 0.0, 4.0) + normal * 2.5;
        let side = seen(&tube, &pose, seam + down * beside);
        assert!((side.value - 1.5).abs() < 1e-13);
        assert!((side.gradient - normal).norm() < 1e-13);
        assert!(side.hessian.column(0).norm() < 1e-12, "{beside}: {}", side.hessian);
        let ball = seen(&tube, &pose, seam - down * beside);
        let far = 2.5_f64.hypot(beside);
        assert!((ball.value - (far - 1.0)).abs() < 1e-13);
        assert!(
            (ball.hessian.trace() - 2.0 / far).abs() < 1e-12,
            "{beside}: {}",
            ball.hessian
        );
    }
}

/// A right-angled bend: on the bisecting plane of its inside both segments are equally near; beside it the nearer one
/// answers, on it the first.
#[test]
fn beside_a_tie_the_nearer_segment_answers() {
    let axis = [Point3::new(4.0, 0.0, 0.0), Point3::origin(), Point3::new(0.0, 4.0, 0.0)];
    let tube = Tube::new(Isometry3::identity(), &axis, &[0.5; 3]).unwrap();
    let (first, second) = (Vector3::y(), Vector3::x());
    let tie = tube.signed_distance(&Vector3::new(1.5, 1.5, 0.0));
    assert_eq!((tie.value, tie.gradient), (1.0, first));
    for beside in BESIDE {
        let to_first = tube.signed_distance(&Vector3::new(1.5, 1.5 - beside, 0.0));
        assert!((to_first.value - (1.0 - beside)).abs() < 1e-15);
        assert_eq!(to_first.gradient, first);
        let to_second = tube.signed_distance(&Vector3::new(1.5 - beside, 1.5, 0.0));
        assert!((to_second.value - (1.0 - beside)).abs() < 1e-15);
        assert_eq!(to_second.gradient, second);
    }
}

/// On the axis and beside it: never NaN, the depth right, the normal of length 1 and, off the axis, the true one.
#[test]
fn the_axis_has_a_depth_and_a_stated_normal() {
    for size in [1e-6, 1.0, 1e6] {
        let axis = [Point3::origin(), Point3::new(0.0, 0.0, 4.0 * size)];
        for radii in [[0.5 * size; 2], [0.5 * size, 0.3 * size]] {
            let tube = Tube::new(Isometry3::identity(), &axis, &radii).unwrap();
            for along in [-0.0, 1.0, 2.0, 4.0] {
                let radius = radii[0] + (radii[1] - radii[0]) * along / 4.0;
                let on = tube.signed_distance(&Vector3::new(0.0, 0.0, along * size));
                assert!((on.value + radius).abs() < 1e-14 * size);
                assert!((on.gradient.norm() - 1.0).abs() < 1e-15);
                assert_eq!(on.hessian, Matrix3::zeros());
                for beside in BESIDE {
                    let off = tube.signed_distance(&Vector3::new(0.0, beside * size, along * size));
                    assert!((off.value + radius - beside * size).abs() < 0.01 * beside * size + 1e-14 * size);
                    assert!(off.gradient.y > 0.99 && off.hessian.iter().all(|h| h.is_finite()));
                    let curvature = off.hessian.trace() * beside * size;
                    assert!((0.99..2.01).contains(&curvature), "{curvature}");
                }
            }
        }
    }
}

/// Nearer to the axis than 1e-12 radii the stated normal is given, with no curvature; farther away the true ones are.
#[test]
fn beside_the_axis_the_stated_normal_gives_way_to_the_true_one() {
    let axis = [Point3::origin(), Point3::new(0.0, 0.0, 4.0)];
    let tube = Tube::new(Isometry3::identity(), &axis, &[1.0; 2]).unwrap();
    for z in [0.0, 2.0, 4.0] {
        let on = tube.signed_distance(&Vector3::new(0.0, 0.0, z));
        assert!(on.gradient.z.abs() < 1e-15);
        for off in [Vector3::new(0.6, 0.8, 0.0), Vector3::new(-0.6, -0.8, 0.0)] {
            let stated = tube.signed_distance(&(Vector3::z() * z + off * 0.9e-12));
            assert_eq!((stated.gradient, stated.hessian), (on.gradient, Matrix3::zeros()));
            let own = tube.signed_distance(&(Vector3::z() * z + off * 1.1e-12));
            assert!((own.gradient - off).norm() < 1e-3 && own.hessian.norm() > 0.9e12 / 1.1);
        }
    }
}

/// Points so near that the normal's direction is rounding: finite all the same, down to the least number there is.
#[test]
fn places_at_the_edge_of_the_numbers_are_finite() {
    let axis = [Point3::origin(), Point3::new(0.0, 0.0, 1.0)];
    let tube = Tube::new(Isometry3::identity(), &axis, &[0.5; 2]).unwrap();
    for x in [f64::MIN_POSITIVE, 5e-324, 1e-200, 1e-13, 1e70] {
        for place in [
            Vector3::new(x, 0.0, 0.5),
            Vector3::new(x, x, -x),
            Vector3::new(0.0, -x, 1.0 + x),
        ] {
            let found = tube.signed_distance(&place);
            assert!(
                found.value.is_finite() && found.hessian.iter().all(|h| h.is_finite()),
                "{x}"
            );
            assert!((found.gradient.norm() - 1.0).abs() < 1e-14, "{x}: {}", found.gradient);
        }
    }
}
