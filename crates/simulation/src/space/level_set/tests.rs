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

/// A block of voxels of 2 mm from -24 to 0 mm along z, with a fin of 4 mm on it, 20 mm high, across x = 0; smoothed by 1.5 mm.
fn finned() -> LabelField {
    let (size, spacing) = ([40, 40, 30], Vector3::repeat(2.0));
    let origin = Vector3::new(-39.0, -39.0, -29.0);
    let is_in = |at: Vector3<f64>| {
        let block = at.z > -24.0 && at.z < 0.0 && at.x.abs() < 30.0;
        at.y.abs() < 30.0 && (block || (at.x.abs() < 2.0 && (0.0..20.0).contains(&at.z)))
    };
    let labels: Vec<u16> = (0..size[0] * size[1] * size[2])
        .map(|n| [n % size[0], n / size[0] % size[1], n / (size[0] * size[1])])
        .map(|at| u16::from(is_in(origin + Vector3::from(at.map(|i| 2.0 * i as f64)))))
        .collect();
    let map = LabelMap {
        size,
        origin,
        spacing,
        labels: &labels,
    };
    let smoothing = Smoothing {
        sigma: 1.5,
        ..Smoothing::default()
    };
    LabelField::new(&map, 1, &smoothing).unwrap()
}

/// A flat patch of an organ, 20 mm to both sides of the fin's foot, so far over it.
fn patch(height: f64) -> Vec<Vector3<f64>> {
    let each = (0..21 * 21).map(|n| [n % 21, n / 21].map(|k| 2.0 * f64::from(k) - 20.0));
    each.map(|[x, y]| Vector3::new(x, y, height)).collect()
}

#[test]
fn parts_of_a_ball_have_its_area() {
    let ball = Ball {
        centre: Vector3::new(0.3, 0.2, -0.1),
        radius: 20.0,
    };
    let corners = [Vector3::repeat(-23.0), Vector3::repeat(22.0)];
    for spacing in [5.0, 2.0] {
        let (parts, _) = cover::parts(&ball, corners, spacing, &|_, _| true).unwrap();
        let area: f64 = parts.iter().map(|p| p.area(&foot::unit(&ball.slope(&p.foot)))).sum();
        // A plane in the place of the ball in boxes of this diagonal lies off by its square over 8 radii at most, and so is what it covers of the ball: twice that over the radius.
        let bound = 2.0 * spacing * spacing / (8.0 * 20.0) / 20.0;
        let whole = 4.0 * std::f64::consts::PI * 400.0;
        assert!((area / whole - 1.0).abs() < bound, "{area} {whole} {bound}");
    }
}

#[test]
fn round_an_organ_distances_are_those_of_the_whole_surface() {
    let (whole, organ) = (bean(), [Vector3::new(0.0, -16.0, 0.0), Vector3::new(5.0, -16.0, 2.0)]);
    let field = Arc::new(BeanField(whole.clone()));
    let near = LevelSet::about(field, &organ, 9.0, 4.0).unwrap();
    assert!(near.feet.points().len() < whole.feet.points().len() / 2);
    assert_eq!(near.left_out(), None);
    let (mut state, mut seen) = (5, 0);
    for _ in 0..2000 {
        let x = organ[0] + within(&mut state, 9.0);
        if (x - organ[0]).norm() > 9.0 {
            continue;
        }
        let (found, expected) = (near.signed_distance(&x), whole.signed_distance(&x));
        // Within reach of the organ and nearer to the surface than the ball is wide.
        if expected.value.abs() > 3.5 {
            continue;
        }
        seen += 1;
        assert!(
            (found.value - expected.value).abs() < 1e-12 * 100.0,
            "{x} {found:?} {expected:?}"
        );
        assert!(near.clearance(&x) <= expected.value);
    }
    assert!(seen > 200, "{seen}");
    let away = LevelSet::about(Arc::new(finned()), &[Vector3::repeat(500.0)], 9.0, 4.0);
    assert_eq!(away.err(), Some(NoSurface::Empty));
}

/// The field of a surface.
#[derive(Debug)]
struct BeanField(LevelSet);

impl Field for BeanField {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        self.0.field().value(at)
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.0.field().slope(at)
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [f64; 2] {
        self.0.field().bounds(low, high)
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [[f64; 2]; 3] {
        self.0.field().slope_bounds(low, high)
    }

    fn resolution(&self) -> f64 {
        self.0.field().resolution()
    }
}

impl Curved for BeanField {
    fn curvature(&self, at: &Vector3<f64>) -> Matrix3<f64> {
        self.0.field().curvature(at)
    }
}

#[test]
fn an_edge_thinner_than_the_ball_is_left_out_and_told_and_what_comes_to_it_is_not_proved() {
    let organ = patch(26.0);
    let set = LevelSet::about(Arc::new(finned()), &organ, 24.0, 4.0).unwrap();
    let left = set.left_out().unwrap();
    println!("{left:?}");
    // Its two sides as long as the block, down to 2 mm over that, which is as far as is looked, and the block's own edges are not; the foot's and the rim's rounding by the smoothing and a ball of 4 mm.
    let [least, most] = [2.0 * 40.0 * (18.0 - 6.0), 2.0 * 64.0 * (20.0 + 6.0)];
    assert!(left.area > least && left.area < most, "{left:?}");
    // From 26 mm down to its rim at 20 mm, which smoothing takes back by a voxel at most; from a foot at most a cover from the rim.
    assert!((6.0 - set.cover..8.0 + set.cover).contains(&left.apart), "{left:?}");
    let unproved = |from: [f64; 3], to: [f64; 3]| set.unproved([&from.into(), &to.into()], 4.0, &|| 1.0);
    let at = [10.0, 0.0, 26.0];
    // At rest, straight down beside the fin, and up.
    for to in [at, [10.0, 0.0, 4.0], [10.0, 0.0, 40.0]] {
        assert_eq!(unproved(at, to), None, "{to:?}");
    }
    // Onto it; over it to its other side, where both ends are far from it.
    for to in [[1.0, 0.0, 19.0], [-8.0, 0.0, 16.0]] {
        assert!(
            matches!(unproved(at, to), Some(Unproved::Edge { apart, .. }) if apart < 1.0),
            "{to:?}"
        );
    }
    let far = [10.0, 29.5, 26.0];
    assert!(matches!(unproved(at, far), Some(Unproved::Beyond { moved, .. }) if moved == 29.5));
    // Without the fin within reach there is nothing to say.
    let beside: Vec<Vector3<f64>> = organ
        .iter()
        .filter(|at| at.x == 18.0 && at.y.abs() < 15.0)
        .copied()
        .collect();
    let low: Vec<Vector3<f64>> = beside.iter().map(|at| Vector3::new(at.x, at.y, 5.0)).collect();
    let set = LevelSet::about(Arc::new(finned()), &low, 7.0, 4.0).unwrap();
    assert_eq!(set.left_out(), None);
}
