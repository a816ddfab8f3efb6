//! Integrals over parts of boxes against closed forms.

use std::f64::consts::PI;

use nalgebra::Vector3;
use simulation::space::cells::{Ball, Depth, Field, Plane, Rule, Shell};

use crate::random;

/// Volume, area and greatest distance of surface points from the surface, of all boxes of a side about the origin.
fn over_boxes(field: &dyn Field, side: f64, reach: f64, depth: Depth) -> [f64; 3] {
    let n = (reach / side).ceil() as i32 + 1;
    let (mut volume, mut area, mut off) = (0.0, 0.0, 0.0_f64);
    for index in 0..(2 * n).pow(3) {
        let at = [index % (2 * n), index / (2 * n) % (2 * n), index / (4 * n * n)];
        let low = Vector3::from(at.map(|k| f64::from(k - n) * side));
        let rule = Rule::of(field, &low, &low.add_scalar(side), depth);
        volume += rule.volume();
        area += rule.area();
        for point in &rule.surface {
            off = off.max(field.value(&point.at).abs());
            assert!((point.normal.norm() - 1.0).abs() < 1e-12 && point.area > 0.0);
        }
        for point in &rule.inside {
            assert!(field.value(&point.at) <= 1e-12 && point.weight > 0.0);
        }
    }
    [volume, area, off]
}

#[test]
fn a_ball_has_its_volume_and_area_wherever_the_boxes_lie() {
    let (radius, mut state) = (25.0, 1);
    let mut worst = [[0.0_f64; 2]; 2];
    for _ in 0..10 {
        let centre = Vector3::from_fn(|_, _| 10.0 * random(&mut state));
        let ball = Ball { centre, radius };
        for (worst, side) in worst.iter_mut().zip([20.0, 5.0]) {
            let [volume, area, off] = over_boxes(&ball, side, radius + 10.0, Depth::default());
            worst[0] = worst[0].max((volume / (4.0 / 3.0 * PI * radius.powi(3)) - 1.0).abs());
            worst[1] = worst[1].max((area / (4.0 * PI * radius.powi(2)) - 1.0).abs());
            // Roots are found to the last digits of a place some 40 mm from zero.
            assert!(off < 1e-12, "{off}");
        }
    }
    println!("volume and area off by {worst:?} at sides of 20 and 5 mm");
    // Four Gauss points an axis integrate the graph of a surface of radius 25 with an error of order 8 in the side: boxes
    // of four fifths of the radius are off by 1e-4, a quarter of that side by 4^8 less. One order is left to the parts that
    // are cut.
    assert!(worst[0][0] < 1e-3 && worst[0][1] < 1e-2, "{worst:?}");
    assert!(
        worst[1][0] < 1e-3 / 4_f64.powi(7) && worst[1][1] < 1e-2 / 4_f64.powi(7),
        "{worst:?}"
    );
}

#[test]
fn a_shell_has_both_surfaces() {
    let mut state = 7;
    for _ in 0..5 {
        let centre = Vector3::from_fn(|_, _| 10.0 * random(&mut state));
        let shell = Shell {
            centre,
            radii: [10.0, 20.0],
        };
        let [volume, area, _] = over_boxes(&shell, 5.0, 30.0, Depth::default());
        let exact = [4.0 / 3.0 * PI * 7000.0, 4.0 * PI * 500.0];
        println!("{:e} {:e}", volume / exact[0] - 1.0, area / exact[1] - 1.0);
        assert!((volume / exact[0] - 1.0).abs() < 1e-5 && (area / exact[1] - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_plane_is_exact_for_polynomials() {
    let mut state = 3;
    for round in 0..200 {
        let mut normal = Vector3::from_fn(|_, _| 2.0 * random(&mut state) - 1.0);
        // Planes along faces, edges and diagonals too.
        match round % 5 {
            1 => normal.x = 0.0,
            2 => normal = Vector3::new(normal.x, 0.0, 0.0),
            3 => normal = Vector3::new(1.0, 1.0, normal.z.signum()),
            4 => normal.y *= 1e-9,
            _ => {}
        }
        let plane = Plane {
            point: Vector3::zeros(),
            normal,
        };
        let rule = Rule::of(&plane, &Vector3::repeat(-1.0), &Vector3::repeat(1.0), Depth::default());
        assert!(
            (rule.volume() - 4.0).abs() < 1e-12,
            "{round} {normal:?} {}",
            rule.volume()
        );
        // The other half has the same moments of even degree.
        for powers in [[2, 0, 0], [0, 2, 4], [2, 2, 2], [1, 1, 0], [1, 3, 2], [0, 0, 6]] {
            let term = |x: &Vector3<f64>| (0..3).map(|k| x[k].powi(powers[k])).product::<f64>();
            let found: f64 = rule.inside.iter().map(|p| p.weight * term(&p.at)).sum();
            let axis = |p: i32| if p % 2 == 0 { 2.0 / f64::from(p + 1) } else { 0.0 };
            let exact = 0.5 * powers.iter().map(|p| axis(*p)).product::<f64>();
            assert!(
                (found - exact).abs() < 1e-12,
                "{round} {normal:?} {powers:?}: {found} {exact}"
            );
        }
    }
}
