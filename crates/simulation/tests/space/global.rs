//! Solids in a deformable block: the same as an element where they fill it, and contact of one.

use nalgebra::{Rotation3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Settings};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Global, NoBlock, Solid};
use simulation::space::system::System;
use simulation::space::term::{ObstacleContact, OrganContact};
use simulation::sparse::Triplets;

use crate::contact::obstacle::{below, newton, surface};
use crate::contact::organs::block;
use crate::random;
use crate::terms::check;

fn material() -> Material {
    Material::new(Law::NeoHookean, 1.0, 0.4).unwrap()
}

fn ball() -> (Ball, Mesh) {
    let ball = Ball {
        centre: Vector3::new(0.0, 0.0, 21.0),
        radius: 20.0,
    };
    let corners = [Vector3::new(-21.0, -21.0, 0.0), Vector3::new(21.0, 21.0, 42.0)];
    (
        ball,
        Mesh::new(&ball, corners, &Settings::of_side(14.0), &|_, _| false).unwrap(),
    )
}

#[test]
fn a_cube_that_fills_its_block_is_the_element() {
    let corners = [Vector3::zeros(), Vector3::repeat(10.0)];
    let mesh = block(corners.map(Into::into), &Settings::of_side(10.0), &|_, _| false);
    let weight = Vector3::new(0.01, -0.02, 0.03);
    let one = Deformable::new(mesh.clone(), material(), weight).unwrap();
    let other = Global::new(&mesh, material(), weight, corners).unwrap();
    let mut state = 11;
    let values: Vec<f64> = (0..81).map(|_| 1.0 * (random(&mut state) - 0.5)).collect();
    // Nodes by their places: the mesh has an order of its own.
    let order: Vec<usize> = other
        .places()
        .chunks_exact(3)
        .map(|at| mesh.nodes_where(|x| <[f64; 3]>::from(*x) == at[0])[0])
        .collect();
    let a: Vec<f64> = order.iter().flat_map(|n| values[3 * n..3 * n + 3].to_vec()).collect();
    let mut gradients = [vec![0.0; 81], vec![0.0; 81]];
    let energies = [
        one.gradient(&values, &mut gradients[0]),
        other.gradient(&a, &mut gradients[1]),
    ]
    .map(Option::unwrap);
    // One in lanes, the other by the table: by rounding apart.
    assert!((energies[0] / energies[1] - 1.0).abs() < 1e-12, "{energies:?}");
    assert!((other.energy(&a).unwrap() / energies[1] - 1.0).abs() < 1e-12);
    let most = gradients[0].iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    for (k, n) in order.iter().enumerate() {
        for i in 0..3 {
            assert!((gradients[0][3 * n + i] - gradients[1][3 * k + i]).abs() < 1e-12 * most);
        }
    }
    let mut matrices = [Triplets::new(81), Triplets::new(81)];
    one.hessian(&values, false, &mut matrices[0], 0).unwrap();
    other.hessian(&a, false, &mut matrices[1], 0).unwrap();
    let turned: Vec<f64> = order
        .iter()
        .flat_map(|n| gradients[0][3 * n..3 * n + 3].to_vec())
        .collect();
    let [first, second] = [matrices[0].product(&gradients[0]), matrices[1].product(&turned)];
    let most = first.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    for (k, n) in order.iter().enumerate() {
        assert!((0..3).all(|i| (first[3 * n + i] - second[3 * k + i]).abs() < 1e-12 * most));
    }
    assert!((one.least_determinant(&values) - other.least_determinant(&a)).abs() < 1e-12);
}

#[test]
fn a_motion_without_strain_costs_nothing_and_moves_the_surface() {
    let (ball, mesh) = ball();
    let corners = [Vector3::new(-25.0, -22.0, 0.0), Vector3::new(21.0, 30.0, 45.0)];
    let solid = Global::new(&mesh, material(), Vector3::zeros(), corners).unwrap();
    let mut a = solid.initial();
    let (turn, way) = (
        Rotation3::from_scaled_axis(Vector3::new(0.5, -1.0, 0.8)),
        Vector3::new(3.0, 4.0, -5.0),
    );
    solid.rotate(&mut a, &turn, ball.centre);
    solid.translate(&mut a, way);
    // Rounding of a gradient of order one.
    let energy = solid.energy(&a).unwrap();
    assert!(energy.abs() < 1e-14 * mesh.volume(), "{energy:e}");
    for k in 0..solid.points() {
        let (at, _, _) = solid.reference(k);
        let exact = ball.centre + turn * (at - ball.centre) + way;
        assert!((solid.point(&a, k) - exact).norm() < 1e-12);
    }
}

#[test]
fn derivatives_of_contact_of_two_blocks() {
    let (ball, mesh) = ball();
    let corners = [Vector3::new(-21.0, -21.0, 0.0), Vector3::new(21.0, 21.0, 42.0)];
    let mut system = System::new();
    for _ in 0..2 {
        system.add(Global::new(&mesh, material(), Vector3::zeros(), corners).unwrap());
    }
    let mut state = 12;
    let mut a: Vec<f64> = (0..system.bodies.size())
        .map(|_| 0.5 * (random(&mut state) - 0.5))
        .collect();
    // The second 1.5 mm in the first.
    a.iter_mut().skip(81).step_by(3).for_each(|u| *u += 38.5);
    let contact = OrganContact::new(&system.bodies, [0, 1], surface(ball, 20.0), 2.0, |_, _| true).unwrap();
    check(&contact, &system, &a);
}

#[test]
fn a_ball_in_a_block_rests_on_bone() {
    let (_, mesh) = ball();
    let weight = -Vector3::z() * 1e-4;
    let corners = [Vector3::new(-21.0, -21.0, 0.0), Vector3::new(21.0, 21.0, 42.0)];
    let solid = Global::new(&mesh, material(), weight, corners).unwrap();
    let mut system = System::new();
    let body = system.add(solid);
    // The block's axis is held sideways, and one more node from turning about it.
    let places = system.places();
    for k in 0..27 {
        let [x, y, _] = places[3 * k];
        let axis = x == 0.0 && y == 0.0;
        system.fixed[3 * k] = axis;
        system.fixed[3 * k + 1] = axis || y == 0.0;
    }
    let bone = ObstacleContact::new(&system.bodies, body, surface(below(0.0), 10.0), 2.0, |_, n| n.z < 0.0).unwrap();
    system.obstacles.push(bone);
    let (mut search, mut a) = (newton(&system, 1e-8), system.initial());
    settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
    let force = system.obstacles[0].force(&system.bodies, &a).force.z;
    assert!((force / (weight.z * mesh.volume()) - 1.0).abs() < 1e-6, "{force}");
}

#[test]
fn a_block_that_does_not_hold_the_solid_is_refused() {
    let (_, mesh) = ball();
    let high = Vector3::new(21.0, 21.0, 42.0);
    for low in [Vector3::new(-19.0, -21.0, 0.0), Vector3::repeat(f64::NAN), high] {
        let refused = Global::new(&mesh, material(), Vector3::zeros(), [low, high]);
        assert!(matches!(refused, Err(NoBlock::Outside { .. })));
    }
}
