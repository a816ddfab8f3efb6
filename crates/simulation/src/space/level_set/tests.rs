//! Distances against closed forms, derivatives by differences, and what is refused.

use nalgebra::{Matrix3, Vector3};

use super::*;
use crate::space::cells::{Ball, Field, LabelField, LabelMap, Plane, Shell, Smoothing};

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

fn within(state: &mut u64, half: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| half * (2.0 * random(state) - 1.0))
}

fn ball(radius: f64) -> (LevelSet, Vector3<f64>) {
    let centre = Vector3::new(1.0, -2.0, 0.5);
    let corners = [centre.add_scalar(-2.0 * radius), centre.add_scalar(2.0 * radius)];
    (
        LevelSet::new(Arc::new(Ball { centre, radius }), corners, radius).unwrap(),
        centre,
    )
}

#[test]
fn a_balls_distance_is_that_from_its_centre() {
    let mut state = 1;
    // Of any size: nothing is absolute.
    for radius in [1e-3, 1.0, 20.0, 1e3] {
        let (set, centre) = ball(radius);
        for _ in 0..300 {
            let from = within(&mut state, 2.0 * radius);
            let (found, apart) = (set.signed_distance(&(centre + from)), from.norm());
            let normal = from / apart;
            let hessian = (Matrix3::identity() - normal * normal.transpose()) / apart;
            // Rounding of places, and near the centre what the normal makes of it.
            let rounding = 1e-13 * (radius + centre.norm());
            assert!((found.value - (apart - radius)).abs() < rounding, "{found:?}");
            let carried = rounding / apart.min(radius) * (1.0 + radius / apart);
            assert!((found.gradient - normal).norm() < carried, "{found:?} {normal}");
            assert!(
                (found.hessian - hessian).norm() < 10.0 * carried / apart,
                "{found:?} {hessian}"
            );
            assert!(set.clearance(&(centre + from)) <= found.value);
        }
    }
}

#[test]
fn a_planes_distance_is_its_field_beyond_the_box_too() {
    let normal = Vector3::new(1.0, 2.0, -2.0);
    let plane = Plane {
        point: Vector3::new(3.0, 1.0, 2.0),
        normal: normal * 5.0,
    };
    let set = LevelSet::new(Arc::new(plane), [Vector3::repeat(-10.0), Vector3::repeat(10.0)], 4.0).unwrap();
    let mut state = 2;
    for _ in 0..500 {
        let x = within(&mut state, 30.0);
        let found = set.signed_distance(&x);
        assert!((found.value - plane.value(&x) / 15.0).abs() < 1e-13 * 60.0);
        assert!((found.gradient - normal / 3.0).norm() < 1e-14 && found.hessian.norm() < 1e-14);
        assert!(set.clearance(&x) <= found.value);
    }
}

/// A bean of voxels of 2, 2 and 3 mm, 36 mm long, with a hollow on one side.
fn bean() -> LevelSet {
    let (size, spacing) = ([40, 30, 20], Vector3::new(2.0, 2.0, 3.0));
    let inside = |x: Vector3<f64>| {
        let bent = x - Vector3::new(0.0, x.x * x.x / 60.0, 0.0);
        bent.component_div(&Vector3::new(26.0, 14.0, 14.0)).norm() < 1.0
    };
    let origin = Vector3::new(-39.0, -29.0, -28.5);
    let labels: Vec<u16> = (0..size[0] * size[1] * size[2])
        .map(|n| [n % size[0], n / size[0] % size[1], n / (size[0] * size[1])])
        .map(|at| {
            u16::from(inside(
                origin + Vector3::from(at.map(|i| i as f64)).component_mul(&spacing),
            ))
        })
        .collect();
    let map = LabelMap {
        size,
        origin,
        spacing,
        labels: &labels,
    };
    let smoothing = Smoothing {
        sigma: 3.0,
        ..Smoothing::default()
    };
    let field = LabelField::new(&map, 1, &smoothing).unwrap();
    let corners = field.corners;
    LevelSet::new(Arc::new(field), corners, 4.0).unwrap()
}

#[test]
fn a_labels_distance_is_to_the_nearest_point_of_its_surface_and_has_its_derivatives() {
    let set = bean();
    let mut state = 3;
    let (mut near, mut far) = (0, 0);
    for _ in 0..3000 {
        let x = within(&mut state, 36.0);
        let found = set.signed_distance(&x);
        assert!(set.clearance(&x) <= found.value, "{x}");
        assert_eq!(found.value > 0.0, set.field().value(&x) > 0.0, "{x} {found:?}");
        // No point of the surface that is known is nearer, and the foot is one of the surface.
        let foot = x - found.gradient * found.value;
        let slope = set.field().slope(&foot).norm();
        assert!((set.field().value(&foot) / slope).abs() < 1e-12 * 100.0);
        let (_, sample) = set.feet.nearest(&x);
        assert!(found.value.abs() <= sample + 1e-12, "{x} {found:?} {sample}");
        // Deeper than the ball's radius, or far outside, another part of the surface may be as near.
        if !(-3.5..3.0).contains(&found.value) {
            far += 1;
            continue;
        }
        near += 1;
        check(&set, &x);
    }
    assert!(near > 200 && far > 200, "{near} {far}");
}

fn check(set: &LevelSet, x: &Vector3<f64>) {
    let (h, found) = (1e-5, set.signed_distance(x));
    for k in 0..3 {
        let step = Vector3::ith(k, h);
        let [up, down] = [x + step, x - step].map(|x| set.signed_distance(&x));
        // Values are good to 1e-13 of 40 mm, curvature is below 1/mm, and third derivatives of a cubic spline jump: h of them.
        assert!(((up.value - down.value) / (2.0 * h) - found.gradient[k]).abs() < 1e-7);
        let slope = (up.gradient - down.gradient) / (2.0 * h);
        assert!(
            (slope - found.hessian.column(k)).norm() < 1e-3,
            "{x} {slope} {}",
            found.hessian
        );
    }
}

#[test]
fn what_is_thinner_or_sharper_than_the_ball_is_refused_and_what_is_no_surface() {
    let corners = [Vector3::repeat(-50.0), Vector3::repeat(50.0)];
    let (centre, normal) = (Vector3::zeros(), Vector3::z());
    let new = |field: Arc<dyn Curved>, radius: f64| LevelSet::new(field, corners, radius).map(|_| ());
    let ball: Arc<dyn Curved> = Arc::new(Ball { centre, radius: 20.0 });
    assert_eq!(new(ball.clone(), 20.0), Ok(()));
    assert!(matches!(new(ball.clone(), 20.1), Err(NoSurface::Thin { .. })));
    // A wall of 10 mm holds a ball of 5.
    let shell: Arc<dyn Curved> = Arc::new(Shell {
        centre,
        radii: [20.0, 30.0],
    });
    assert_eq!(new(shell.clone(), 4.9), Ok(()));
    assert!(matches!(new(shell, 5.1), Err(NoSurface::Thin { .. })));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(new(ball.clone(), bad), Err(NoSurface::Radius { .. })));
    }
    assert!(matches!(new(ball.clone(), 0.01), Err(NoSurface::TooMany { .. })));
    let away = Plane {
        point: normal * 1e3,
        normal,
    };
    assert_eq!(new(Arc::new(away), 1.0), Err(NoSurface::Empty));
    let flat = LevelSet::new(ball, [Vector3::zeros(), Vector3::new(1.0, 0.0, 1.0)], 1.0);
    assert!(matches!(flat, Err(NoSurface::Box { .. })));
}
