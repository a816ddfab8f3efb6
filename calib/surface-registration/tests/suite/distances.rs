//! Distances, sides and the field, against closed forms.

use chance::Chance;
use geometry::{Ct, Point};
use surface_registration::{Field, Spacing, Surface};

use crate::common::oracle;
use crate::shapes;

fn places(n: u64, reach: f64) -> impl Iterator<Item = [f64; 3]> {
    (0..n).map(move |i| [0, 1, 2].map(|k| reach * (2.0 * Chance::new(4, i).uniform(k) - 1.0)))
}

fn surface((corners, triangles): shapes::Triangles) -> Surface<Ct> {
    Surface::new(&corners, &triangles).unwrap()
}

fn at([x, y, z]: [f64; 3]) -> Point<Ct> {
    Point::new(x, y, z)
}

#[test]
fn a_ball_has_its_distance_and_its_inside() {
    let ball = surface(shapes::ball(40.0, 60));
    // A facet of a ball of radius r with edges of length e lies inside of it by up to e^2 / 4 r: 2.2 mm edges, 0.03 mm.
    for p in places(500, 80.0) {
        let r = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        let d = ball.distance(at(p));
        assert!((d.mm - (r - 40.0)).abs() < 0.035, "{p:?}: {} {}", d.mm, r - 40.0);
        if r > 1.0 && (r - 40.0).abs() > 1.0 {
            let along: f64 = d.normal.iter().zip(p).map(|(n, x)| n * x / r).sum();
            // Near the middle every facet is as near as any other.
            assert!(r < 20.0 || along > 0.99, "{p:?} {along}");
            assert!(
                (ball.winding(at(p)) - f64::from(u8::from(r < 40.0))).abs() < 1e-9,
                "{p:?}"
            );
        }
    }
}

#[test]
fn a_box_has_its_distance_to_rounding() {
    let half = [30.0, 20.0, 10.0];
    let cuboid = surface(shapes::cuboid(half, 4));
    for p in places(500, 50.0) {
        let off = [0, 1, 2].map(|k| p[k].abs() - half[k]);
        let outside = off.iter().map(|x| x.max(0.0).powi(2)).sum::<f64>().sqrt();
        let inside = off.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x)).min(0.0);
        assert!((cuboid.distance(at(p)).mm - (outside + inside)).abs() < 1e-12, "{p:?}");
    }
}

#[test]
fn a_tube_is_open_where_it_ends() {
    let tube = surface(shapes::tube(15.0, 40.0, 90));
    assert_eq!((tube.facts().open_ends.len(), tube.facts().open_edges), (2, 180));
    for [x, y, z] in places(500, 39.0) {
        let p = [x, y, z];
        let d = tube.distance(at(p));
        // Facets lie inside by up to 15 (1 - cos 2 degrees) = 0.01 mm.
        assert!((d.mm - (x.hypot(y) - 15.0)).abs() < 0.012, "{p:?} {d:?}");
        assert!(!d.is_open);
        assert!(tube.distance(at([x, y, z.signum() * (41.0 + z.abs())])).is_open);
    }
}

/// The first difference of a field that is linear between nodes is its own gradient.
#[test]
fn the_gradient_is_the_slope_of_the_field() {
    let field = Field::new(&surface(shapes::ball(40.0, 30)), Spacing::default()).unwrap();
    let mut looked = 0;
    for p in places(300, 70.0) {
        let (_, g) = field.at(at(p));
        for k in 0..3 {
            let h = 1e-4;
            let step = |by: f64| {
                let mut q = p;
                q[k] += by;
                field.at(at(q)).0
            };
            let slope = (step(h) - step(-h)) / (2.0 * h);
            // f64 differences of f32 nodes; a cell's border between the two is a kink, and rare.
            looked += usize::from((slope - g[k]).abs() < 1e-6);
        }
    }
    assert!(looked >= 895, "{looked} of 900");
}

#[test]
fn the_field_is_the_distance_within_its_bound() {
    for (name, surface, reach) in [
        ("ball", surface(shapes::ball(40.0, 40)), 85.0),
        ("cuboid", surface(shapes::cuboid([30.0, 20.0, 10.0], 8)), 60.0),
    ] {
        let field = Field::new(&surface, Spacing::default()).unwrap();
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for p in places(2000, reach) {
            let exact = surface.distance(at(p)).mm;
            let miss = (field.at(at(p)).0 - exact).abs();
            worst = worst.max(miss);
            sum += miss / 2000.0;
            // Linear interpolation between nodes of 2 mm is off by up to half the diagonal of a cell at a kink, 1.73 mm, and a node by a
            // tenth of the spacing.
            assert!(miss < 1.9, "{name} {p:?}: {miss}");
        }
        assert!(sum < 0.12, "{name}: {sum}, worst {worst}");
    }
}

/// A flood leaks out where the CT ended, and every result was 1 mm off.
#[test]
fn an_open_bone_has_its_inside() {
    let Some(bone) = oracle::surface("pelvis-phantom") else {
        return;
    };
    assert_eq!(bone.facts().open_edges, 631);
    let field = Field::new(&bone, Spacing::default()).unwrap();
    let (mut inside, mut looked) = (0, 0);
    for i in 0..4000 {
        let c = Chance::new(9, i);
        let p = at([
            20.0 + 300.0 * c.uniform(0),
            10.0 + 110.0 * c.uniform(1),
            25.0 + 215.0 * c.uniform(2),
        ]);
        let exact = bone.distance(p);
        if exact.is_open || exact.mm.abs() < 2.0 {
            continue;
        }
        looked += 1;
        inside += usize::from(exact.mm < 0.0);
        assert_eq!(field.at(p).0 < 0.0, exact.mm < 0.0, "{p:?} {exact:?}");
    }
    assert!(looked > 3000 && inside > 150, "{inside} of {looked}");
    let deep = (0..4000).map(|i| Chance::new(9, i));
    for c in deep.take(40) {
        let p = at([
            20.0 + 300.0 * c.uniform(0),
            30.0 + 90.0 * c.uniform(1),
            25.0 + 215.0 * c.uniform(2),
        ]);
        let d = bone.distance(p);
        if !d.is_open && d.mm.abs() > 0.5 {
            assert_eq!(bone.winding(p) > 0.5, d.mm < 0.0, "{p:?}");
        }
    }
}

#[test]
fn a_sheet_has_two_sides() {
    let plane = surface(shapes::plane(60.0, 12));
    assert!(plane.facts().is_sheet);
    let field = Field::new(&plane, Spacing::default()).unwrap();
    for [x, y, z] in places(300, 35.0) {
        assert!((field.at(at([x, y, z])).0 - z).abs() < 0.05, "{x} {y} {z}");
    }
}
