//! What moves a place, with derivatives, inside cubes and a little outside.

use nalgebra::{Matrix3, Vector3};
use simulation::space::cells::{Ball, Mesh, Settings};

use crate::contact::organs::block;
use crate::random;

/// A field with all products of second degree and more along each axis, at a place.
fn bent(at: &Vector3<f64>) -> f64 {
    0.01 * at.x * at.x * at.y + 0.02 * at.y * at.z * at.z - at.x * at.z + 3.0 * at.y
}

#[test]
fn weights_are_those_of_the_row_and_have_its_derivatives() {
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 20.0,
    };
    let corners = [Vector3::repeat(-21.0), Vector3::repeat(21.0)];
    for settings in [Settings::of_side(12.0), Settings::of_side(12.0).fast()] {
        let settings = Settings { levels: 1, ..settings };
        let mesh = Mesh::new(&ball, corners, &settings, &|low, _| low.x > 0.0).unwrap();
        let (mut state, mut found) = (4, 0);
        while found < 300 {
            let at = Vector3::from_fn(|_, _| 40.0 * (random(&mut state) - 0.5));
            let Some(row) = mesh.row(&at) else { continue };
            found += 1;
            let shares = mesh.shares(&at).unwrap();
            assert_eq!(row.len(), shares.len());
            let h = 1e-5;
            for (share, (node, weight)) in shares.iter().zip(&row) {
                assert!(share.node == *node && (share.weight - weight).abs() < 1e-14);
            }
            for k in 0..3 {
                let sides = [h, -h].map(|h| mesh.shares(&(at + Vector3::ith(k, h))).unwrap());
                // A face of a cube between them: other nodes.
                if sides.iter().any(|side| side.len() != shares.len()) {
                    continue;
                }
                for (share, (up, down)) in shares.iter().zip(sides[0].iter().zip(&sides[1])) {
                    // Third derivatives are below 1/mm^3 and ties below ten: 1e-9 of that, and rounding by h.
                    let slope = (up.weight - down.weight) / (2.0 * h);
                    assert!((slope - share.slope[k]).abs() < 1e-8, "{at}");
                    let curvature = (up.slope - down.slope) / (2.0 * h);
                    assert!((curvature - share.curvature.column(k)).amax() < 1e-8, "{at}");
                }
            }
        }
    }
}

#[test]
fn outside_a_mesh_the_field_goes_on_as_it_is_and_without_a_jump() {
    let mesh = block([[0.0; 3], [30.0, 30.0, 20.0]], &Settings::of_side(10.0), &|_, _| false);
    let value = |at: &Vector3<f64>| -> Option<(f64, Vector3<f64>, Matrix3<f64>)> {
        let shares = mesh.shares(at)?;
        let node = |share: &simulation::space::cells::Share| bent(&mesh.nodes[share.node as usize]);
        Some((
            shares.iter().map(|s| s.weight * node(s)).sum(),
            shares.iter().map(|s| s.slope * node(s)).sum(),
            shares.iter().map(|s| s.curvature * node(s)).sum(),
        ))
    };
    let mut state = 8;
    for _ in 0..300 {
        // At a corner 4.85 mm away, of 5 that are allowed.
        let at = Vector3::from_fn(|k, _| [35.6, 35.6, 25.6][k] * random(&mut state) - 2.8);
        let (found, slope, curvature) = value(&at).unwrap();
        // Of the second degree along each axis: the same polynomial in all cubes.
        assert!((found - bent(&at)).abs() < 1e-10, "{at}");
        let [x, y, z] = [at.x, at.y, at.z];
        let exact = Vector3::new(0.02 * x * y - z, 0.01 * x * x + 0.02 * z * z + 3.0, 0.04 * y * z - x);
        assert!((slope - exact).amax() < 1e-10);
        assert!((curvature[(0, 0)] - 0.02 * y).abs() < 1e-10 && (curvature[(1, 2)] - 0.04 * z).abs() < 1e-10);
    }
    // Of any values on the nodes: no jump across the plane of a shared face outside.
    let values: Vec<f64> = mesh.nodes.iter().map(|_| random(&mut state)).collect();
    for k in 0..50 {
        let at = Vector3::new(20.0, 0.6 * f64::from(k), -3.0);
        let [one, other] = [-1e-9, 1e-9].map(|step| {
            let shares = mesh.shares(&(at + Vector3::x() * step)).unwrap();
            shares.iter().map(|s| s.weight * values[s.node as usize]).sum::<f64>()
        });
        // 2e-9 mm of a slope of some 1/mm.
        assert!((one - other).abs() < 1e-8, "{at} {one} {other}");
    }
    assert!(value(&Vector3::new(15.0, 15.0, -5.1)).is_none() && value(&Vector3::new(f64::NAN, 0.0, 0.0)).is_none());
}
