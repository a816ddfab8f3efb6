//! The thick ball and the manufactured solution, whose exact states are known.

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::cells::{Mesh, Shell};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;

use super::{ratios, settings};
use crate::manufactured;

/// An eighth of a thick ball under inner pressure.
fn octant(mesh: &Mesh, nu: f64, radii: [f64; 2]) -> System {
    let material = Material::new(Law::Linear, 1.0, nu).unwrap();
    let solid = Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap();
    let forces = solid.traction(|at, normal| {
        let inner = at.norm() < 0.5 * (radii[0] + radii[1]) && at.iter().all(|x| x.abs() > 1e-9);
        if inner { -normal * 1e-3 } else { Vector3::zeros() }
    });
    let mut system = System::new();
    let body = system.add(solid);
    System::load(&mut system, body, &forces);
    for k in 0..3 {
        let flat = mesh.nodes_where(|x| x[k].abs() < 1e-9);
        flat.into_iter().for_each(|n| system.fixed[3 * n + k] = true);
    }
    system
}

/// Lame's displacement for Young's modulus 1 and a pressure of 1e-3.
fn lame(nu: f64, [a, b]: [f64; 2], at: &Vector3<f64>) -> Vector3<f64> {
    let (a, b, r) = (a.powi(3), b.powi(3), at.norm());
    at * (1e-3 * a / (b - a) * ((1.0 - 2.0 * nu) + (1.0 + nu) * b / (2.0 * r.powi(3))))
}

/// Stated by true errors near a place of the inner surface and elsewhere.
pub(super) fn thick_ball(cubes: f64, nu: f64, radii: [f64; 2]) -> ([f64; 2], [usize; 2]) {
    let shell = Shell {
        centre: Vector3::zeros(),
        radii,
    };
    let (corners, settings) = (
        [Vector3::zeros(), Vector3::repeat(radii[1])],
        settings(radii[1] / cubes, 0),
    );
    let mesh = Mesh::new(&shell, corners, &settings, &|_, _| false).unwrap();
    let place = (Vector3::repeat(radii[0] / 3_f64.sqrt()), 0.5 * radii[0]);
    ratios(
        (&shell, corners, &settings),
        &mesh,
        |mesh| octant(mesh, nu, radii),
        |at| lame(nu, radii, at),
        place,
    )
}

/// The same of the manufactured solution, near a place of the ball's surface.
pub(super) fn manufactured(cubes: f64, nu: f64, shift: f64) -> ([f64; 2], [usize; 2]) {
    let ((ball, corners), settings) = (manufactured::region(shift), settings(2.6 / cubes, 1));
    let mesh = Mesh::new(&ball, corners, &settings, &|low, high| low.x + high.x < 0.0).unwrap();
    let exact = manufactured::Exact::of(nu);
    ratios(
        (&ball, corners, &settings),
        &mesh,
        |mesh| manufactured::system(mesh, nu).0,
        |at| exact.displacement(at),
        (Vector3::z(), 0.5),
    )
}

#[test]
fn stated_errors_of_known_states_are_no_less_than_true_ones() {
    for (what, (ratios, unknowns)) in [
        ("thick ball, nu 0.3", thick_ball(3.3, 0.3, [20.0, 40.0])),
        ("thick ball, nu 0.49", thick_ball(3.3, 0.49, [20.0, 40.0])),
        ("manufactured, nu 0.3", manufactured(3.0, 0.3, 0.0)),
    ] {
        println!("{what}: {ratios:.2?}, {unknowns:?} unknowns");
        assert!(ratios.iter().all(|r| (1.0..5.0).contains(r)), "{what}: {ratios:?}");
    }
}
