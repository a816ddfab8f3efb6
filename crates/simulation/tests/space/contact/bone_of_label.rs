//! Contact with bone that a label map gives.

use std::sync::Arc;

use nalgebra::Vector3;
use simulation::space::cells::{Ball, LabelField, LabelMap, Settings, Smoothing};
use simulation::space::level_set::LevelSet;

use crate::contact::obstacle::{Pressed, surface};

/// The surface of a ball of voxels of 2 mm.
fn of_voxels(ball: &Ball) -> LevelSet {
    let count = (2.0 * ball.radius / 2.0) as usize + 4;
    let place = |k: usize| 2.0 * (k as f64 - 0.5 * (count - 1) as f64);
    let voxel = |n: usize| Vector3::new(place(n % count), place(n / count % count), place(n / (count * count)));
    let labels: Vec<u16> = (0..count.pow(3))
        .map(|n| u16::from(voxel(n).norm() < ball.radius))
        .collect();
    let map = LabelMap {
        size: [count; 3],
        origin: voxel(0) + ball.centre,
        spacing: Vector3::repeat(2.0),
        labels: &labels,
    };
    let smoothing = Smoothing {
        sigma: 3.0,
        ..Smoothing::default()
    };
    let field = LabelField::new(&map, 1, &smoothing).unwrap();
    let corners = field.corners;
    LevelSet::new(Arc::new(field), corners, 10.0).unwrap()
}

#[test]
fn bone_of_a_label_map_is_the_bone_that_it_is_of() {
    let ball = Ball {
        centre: Vector3::new(0.0, 0.0, -30.0),
        radius: 30.0,
    };
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(12.0)
    };
    // Its pole is a facet of voxels, which stands out by some tenths of a millimetre: lowered by that.
    let out = -of_voxels(&ball).signed_distance(&Vector3::zeros()).value;
    let lowered = Ball {
        centre: ball.centre - Vector3::z() * out,
        ..ball
    };
    assert!(out.abs() < 1.0, "{out}");
    let forces = [surface(ball, 30.0), of_voxels(&lowered)].map(|bone| {
        let mut block = Pressed::new([36.0, 36.0], 0.45, 10.0, bone, &settings);
        [2.0, 5.0, 8.0].map(|depth| {
            let (found, tube, bone) = block.to(depth).unwrap();
            println!(
                "{depth} mm: tube {tube:.6} N, bone {:.6} N at {} points, {} rounds",
                bone.force.z, bone.points, found.rounds
            );
            assert!((tube + bone.force.z).abs() < 1e-6 * tube, "{tube} {bone:?}");
            tube
        })
    });
    println!("out by {out:.3} mm, {forces:.5?}");
    // Beside the facet its surface is lower and higher by a tenth of a millimetre: so much of the depth, and as much again as the
    // force grows faster than the depth.
    for (k, depth) in [2.0, 5.0, 8.0].into_iter().enumerate() {
        let off = forces[1][k] / forces[0][k] - 1.0;
        assert!(off.abs() < 2.0 * 0.1 / depth, "{depth}: {off}");
    }
}
