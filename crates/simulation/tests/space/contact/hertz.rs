//! Balls pressed on plates and on one another, against Hertz.

use std::f64::consts::PI;

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Plane, Settings};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{ObstacleContact, OrganContact};

use crate::contact::obstacle::{hold, newton, surface};
use crate::contact::organs::deformable;

/// What the force on the other side of a ball of this radius takes from the approach of its centre: Boussinesq's displacement
/// at the rim of a contact, by the force opposite (as Tatara 1991 has it).
fn approach_of_ball(radius: f64, nu: f64, young: f64, force: f64, contact: f64) -> f64 {
    let apart = contact * contact + 4.0 * radius * radius;
    let other = 2.0 * (1.0 + nu) * radius * radius / apart.powf(1.5) + (1.0 - nu * nu) / apart.sqrt();
    force * other / (PI * young)
}

#[test]
fn a_ball_between_plates_is_that_of_hertz() {
    let (radius, nu) = (20.0, 0.3);
    let ball = Ball {
        centre: Vector3::zeros(),
        radius,
    };
    let pole = Vector3::new(0.0, 0.0, radius);
    let settings = Settings {
        levels: 4,
        ..Settings::of_side(7.0)
    };
    let fine = |low: &Vector3<f64>, high: &Vector3<f64>| {
        let apart = (pole.sup(low).inf(high) - pole).norm();
        apart < 1.5 || apart < high.x - low.x
    };
    let mesh = Mesh::new(&ball, [Vector3::zeros(), Vector3::repeat(21.0)], &settings, &fine).unwrap();
    let material = Material::new(Law::Linear, 1.0, nu).unwrap();
    let mut system = System::new();
    let body = system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
    hold(&mut system, body, &mesh, 3);
    let plate = |depth: f64| {
        let plane = Plane {
            point: pole - Vector3::z() * depth,
            normal: -Vector3::z(),
        };
        surface(plane, 5.0)
    };
    let contact = ObstacleContact::new(&system.bodies, body, plate(0.0), 40.0, |at, _| at.z > 17.0).unwrap();
    system.obstacles.push(contact);
    // Stiffness of contact has grown by 1e4 at the end: times the rounding of places it is 1e-8 of a point's force.
    let (mut search, mut a) = (newton(&system, 1e-7), system.initial());
    for depth in [0.05, 0.1] {
        system.obstacles[0].move_to(plate(depth));
        let found = settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
        let whole = 4.0 * system.obstacles[0].force(&system.bodies, &a).force.z;
        let contact = (0.75 * (1.0 - nu * nu) * radius * whole).cbrt();
        let expected = contact * contact / radius - approach_of_ball(radius, nu, 1.0, whole, contact);
        let hertz = 4.0 / 3.0 / (1.0 - nu * nu) * radius.sqrt() * depth.powf(1.5);
        println!(
            "{} unknowns, {depth} mm, contact's radius {contact:.3} mm: force {whole:.6} N, that of Hertz {:+.2} %, approach for the force {:+.3} %; {} rounds",
            a.len(),
            100.0 * (whole / hertz - 1.0),
            100.0 * (depth / expected - 1.0),
            found.rounds
        );
        // Hertz leaves out the other plate: 0.36 a / R of the approach, half as much again of the force, and as much in
        // higher orders.
        let curved = contact / radius;
        assert!((whole / hertz - 1.0 - 0.55 * curved).abs() < 0.2 * curved);
        // With it: squares of a / R, 0.005, and of quadratic cubes of half the contact's radius at its edge as much.
        assert!((depth / expected - 1.0).abs() < 0.005);
    }
}

#[test]
fn two_balls_are_those_of_hertz() {
    let (radii, nu) = ([20.0, 30.0], 0.3);
    let touch = Vector3::zeros();
    let settings = Settings {
        levels: 4,
        ..Settings::of_side(10.0)
    };
    let fine = |reach: f64| {
        move |low: &Vector3<f64>, high: &Vector3<f64>| {
            let apart = (touch.sup(low).inf(high) - touch).norm();
            apart < reach || apart < high.x - low.x
        }
    };
    let upper = Ball {
        centre: Vector3::z() * radii[0],
        radius: radii[0],
    };
    let lower = Ball {
        centre: -Vector3::z() * radii[1],
        radius: radii[1],
    };
    let meshes = [
        Mesh::new(&upper, [touch, Vector3::new(20.0, 20.0, 20.0)], &settings, &fine(1.6)).unwrap(),
        Mesh::new(
            &lower,
            [Vector3::new(0.0, 0.0, -30.0), Vector3::new(30.0, 30.0, 0.0)],
            &settings,
            &fine(1.6),
        )
        .unwrap(),
    ];
    let mut system = System::new();
    for (mesh, middle) in meshes.iter().zip([20.0, -30.0]) {
        let body = system.add(deformable(mesh, Law::Linear, 1.0, nu));
        hold(&mut system, body, mesh, 2);
        let offset = system.bodies.offset(body);
        for n in mesh.nodes_where(|x| (x.z - middle).abs() < 1e-9) {
            system.fixed[offset + 3 * n + 2] = true;
        }
    }
    let contact = OrganContact::new(&system.bodies, [0, 1], surface(lower, 30.0), 40.0, |at, _| {
        at.norm() < 5.0
    });
    system.organs.push(contact.unwrap());
    let middle = meshes[0].nodes_where(|x| (x.z - 20.0).abs() < 1e-9);
    let (mut search, mut a) = (newton(&system, 1e-7), system.initial());
    let radius = radii[0] * radii[1] / (radii[0] + radii[1]);
    for depth in [0.08, 0.16] {
        middle.iter().for_each(|n| a[3 * n + 2] = -depth);
        system.organs[0].restart();
        let found = settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
        let whole = -4.0 * system.organs[0].force(&system.bodies, &a).force.z;
        let contact = (1.5 * (1.0 - nu * nu) * radius * whole).cbrt();
        let far: f64 = radii
            .iter()
            .map(|r| approach_of_ball(*r, nu, 1.0, whole, contact))
            .sum();
        let expected = contact * contact / radius - far;
        let hertz = 2.0 / 3.0 / (1.0 - nu * nu) * radius.sqrt() * depth.powf(1.5);
        println!(
            "{} unknowns, {depth} mm, contact's radius {contact:.3} mm: force {whole:.6} N, that of Hertz {:+.2} %, approach for the force {:+.3} %; {} rounds, {} steps",
            a.len(),
            100.0 * (whole / hertz - 1.0),
            100.0 * (depth / expected - 1.0),
            found.rounds,
            found.iterations
        );
        // As for a ball between plates.
        assert!((depth / expected - 1.0).abs() < 0.005);
    }
}
