//! Bounds of the determinant between the elements' points.

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Plane, Settings};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};

use crate::push::quarter;
use crate::{now, random};

fn solid(mesh: Mesh) -> Deformable {
    Deformable::new(
        mesh,
        Material::new(Law::NeoHookean, 1.0, 0.4).unwrap(),
        Vector3::zeros(),
    )
    .unwrap()
}

#[test]
fn a_cube_turned_inside_out_between_its_points_is_seen() {
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(25.0)
    };
    for (settings, own) in [(settings, true), (settings.fast(), false)] {
        let solid = solid(quarter(&settings, &[30.0]));
        let mut a = solid.initial();
        let rest = solid.bounded_determinant(&a);
        assert!((rest.0 - 1.0).abs() < 1e-14 && (rest.1 - 1.0).abs() < 1e-14);
        // The node nearest to the middle of a cube of 25 mm: of 27 nodes its own middle one, of 8 a corner.
        let middle = Vector3::new(37.5, 37.5, 37.5);
        let far = |n: &usize| (solid.mesh().nodes[*n] - middle).norm();
        let node = (0..solid.mesh().nodes.len())
            .min_by(|a, b| far(a).total_cmp(&far(b)))
            .unwrap();
        assert_eq!(far(&node) < 1e-9, own);
        // Of 27 nodes det F = 1 - 1.1 x in the middle of a face: -0.1, and 0.148 at Gauss' point.
        a[3 * node] = 0.55 * 12.5;
        let (lower, reached) = solid.bounded_determinant(&a);
        println!("{lower} {reached}");
        assert!(lower <= reached);
        if own {
            assert!(
                (reached + 0.1).abs() < 1e-3 && reached - lower <= 1e-3 + 1e-12,
                "{reached}"
            );
            assert!((solid.least_determinant(&a) - 0.148).abs() < 1e-3 && solid.energy(&a).is_some());
        } else {
            // The edges of 25 mm that end there: one shorter by 6.875 mm.
            assert!(
                (reached - (1.0 - 6.875 / 25.0)).abs() < 1e-12 && lower > 0.0,
                "{reached}"
            );
        }
    }
}

#[test]
fn no_place_inside_a_ball_is_below_the_bound() {
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 20.0,
    };
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(9.0)
    };
    let corners = [Vector3::repeat(-21.0), Vector3::repeat(21.0)];
    let solid = solid(Mesh::new(&ball, corners, &settings, &|low, _| low.x < -5.0).unwrap());
    let mut state = 3;
    let a: Vec<f64> = (0..solid.parameters())
        .map(|_| 0.6 * (random(&mut state) - 0.5))
        .collect();
    let start = now();
    let (lower, reached) = solid.bounded_determinant(&a);
    let (least, cubes) = (solid.least_determinant(&a), solid.mesh().cubes().len());
    println!(
        "bound {lower:.4}, inside {reached:.4}, at points {least:.4}; {cubes} cubes, {:.4} s",
        now() - start
    );
    assert!(lower <= reached && reached <= least && least > 0.0);
}

/// Tissue that ends at a height of 4 in cubes of 10, all of it moved by `-k (z - 2)^2` along z, so that `det F = 1 - 2 k (z - 2)`.
#[test]
fn a_fold_between_the_points_of_a_cut_cube_is_not_upright_and_one_outside_of_the_tissue_is() {
    let top = Plane {
        point: Vector3::new(0.0, 0.0, 4.0),
        normal: Vector3::z(),
    };
    let corners = [Vector3::new(-10.0, -10.0, -10.0), Vector3::new(10.0, 10.0, 10.0)];
    let solid = solid(Mesh::new(&top, corners, &Settings::of_side(10.0), &|_, _| false).unwrap());
    let moved = |k: f64| -> Vec<f64> {
        let nodes = solid.mesh().nodes.iter();
        nodes.flat_map(|x| [0.0, 0.0, -k * (x.z - 2.0).powi(2)]).collect()
    };
    // Below zero above 3.85: in tissue, and above all points of elements, of which the highest lies at 3.72.
    let folded = moved(0.27);
    let at_points = solid.least_determinant(&folded);
    assert!(at_points > 0.05, "{at_points}");
    assert!(!solid.is_upright(&folded, &|_, _| true));
    // Where nobody asks, nothing is said.
    assert!(solid.is_upright(&folded, &|_, _| false));
    // Below zero above 7: in the cut cube, outside of the tissue.
    let beyond = moved(0.1);
    assert!(solid.is_upright(&beyond, &|_, _| true) && solid.bounded_determinant(&beyond).0 < 0.0);
}
