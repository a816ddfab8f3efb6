//! Terms: derivatives by differences.

use nalgebra::{Point3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Settings};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, Term, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Triplets;

use crate::random;

/// A ball with a tube 1 mm in it, and displacements.
pub(crate) fn scene() -> (System, Vec<f64>) {
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 20.0,
    };
    let corners = [Vector3::repeat(-21.0), Vector3::repeat(21.0)];
    let mesh = Mesh::new(&ball, corners, &Settings::of_side(10.0), &|_, _| false).unwrap();
    let material = Material::new(Law::NeoHookean, 1.0, 0.4).unwrap();
    let mut system = System::new();
    system.add(Deformable::new(mesh, material, Vector3::zeros()).unwrap());
    let mut state = 3;
    let a = (0..system.bodies.size())
        .map(|_| 0.2 * (random(&mut state) - 0.5))
        .collect();
    (system, a)
}

pub(crate) fn check(term: &dyn Term, system: &System, a: &[f64]) {
    let mut gradient = vec![0.0; a.len()];
    let energy = term.gradient(&system.bodies, a, &mut gradient).unwrap();
    assert!((energy - term.energy(&system.bodies, a).unwrap()).abs() <= 1e-12 * energy.abs());
    let mut hessian = Triplets::new(a.len());
    term.hessian(&system.bodies, a, false, &mut hessian).unwrap();
    let mut state = 9;
    let direction: Vec<f64> = a.iter().map(|_| random(&mut state) - 0.5).collect();
    let h = 1e-5;
    let along = |t: f64| -> Vec<f64> { a.iter().zip(&direction).map(|(a, d)| a + t * h * d).collect() };
    let sides = [along(1.0), along(-1.0)].map(|a| {
        let mut gradient = vec![0.0; a.len()];
        (term.gradient(&system.bodies, &a, &mut gradient).unwrap(), gradient)
    });
    let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
    let size: f64 = gradient.iter().zip(&direction).map(|(g, d)| (g * d).abs()).sum();
    assert!(size > 0.0);
    assert!(
        ((sides[0].0 - sides[1].0) / (2.0 * h) - slope).abs() < 1e-7 * size,
        "{slope}"
    );
    let product = hessian.product(&direction);
    let most = product.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (i, exact) in product.iter().enumerate() {
        let found = (sides[0].1[i] - sides[1].1[i]) / (2.0 * h);
        // h^2 times third derivatives by a radius of 5 mm, and rounding by h.
        assert!((found - exact).abs() < 1e-7 * most, "{i}: {found} {exact} {most}");
    }
}

#[test]
fn derivatives_of_contact_and_springs() {
    let (system, a) = scene();
    let tube = Tube::straight(Point3::new(2.0, 1.0, 23.0), Vector3::new(0.1, -0.2, 1.0), 50.0, 5.0).unwrap();
    let mut contact = TubeContact::new(&system.bodies, 0, tube, 2.0, |_, _| true).unwrap();
    check(&contact, &system, &a);
    // With pressures too.
    contact.update(&system.bodies, &a);
    check(&contact, &system, &a);
    let force = contact.force(&system.bodies, &a);
    assert!(
        force.force.z > 0.0 && force.points > 3 && force.depth > 0.5,
        "{force:?}"
    );
    check(
        &Springs::new(&system.bodies, 0, |at, _| at.z + 20.0, |at| at * 1.01),
        &system,
        &a,
    );
}

#[test]
fn a_step_never_takes_a_point_deeper_than_half_the_radius() {
    let (system, a) = scene();
    let tube = Tube::straight(Point3::new(0.0, 0.0, 24.9), Vector3::z(), 50.0, 5.0).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube, 2.0, |_, _| true).unwrap();
    for up in [1.0, 5.0, 100.0] {
        let step: Vec<f64> = (0..a.len()).map(|i| if i % 3 == 2 { up } else { 0.0 }).collect();
        let reach = contact.reach(&system.bodies, &a, &step);
        let moved: Vec<f64> = a.iter().zip(&step).map(|(a, s)| a + reach * s).collect();
        assert!(contact.depth(&system.bodies, &moved) <= contact.deepest() * (1.0 + 1e-12));
        assert!(reach > 0.0 && (up > 2.0 || reach == 1.0), "{up} {reach}");
    }
}

#[test]
fn a_stiffness_that_draws_points_in_is_refused() {
    let (system, _) = scene();
    let tube = Tube::straight(Point3::new(0.0, 0.0, 30.0), Vector3::z(), 50.0, 5.0).unwrap();
    for stiffness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let contact = TubeContact::new(&system.bodies, 0, tube.clone(), stiffness, |_, _| true);
        assert!(contact.is_err(), "{stiffness}");
    }
}
