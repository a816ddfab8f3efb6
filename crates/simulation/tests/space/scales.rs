//! One scene in other units.
use nalgebra::{Point3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Settings};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;

use crate::common::newton;

/// Displacements by the unit of length, the force by those of length and stress, and steps.
fn scene(length: f64, stress: f64) -> (Vec<f64>, f64, usize) {
    let at = |x: f64| x * length;
    let ball = Ball {
        centre: Vector3::new(1.0, 2.0, 3.0).map(at),
        radius: at(20.0),
    };
    let corners = [Vector3::repeat(-20.0).map(at), Vector3::repeat(24.0).map(at)];
    let mesh = Mesh::new(&ball, corners, &Settings::of_side(at(11.0)), &|_, _| false).unwrap();
    let material = Material::new(Law::NeoHookean, 5.0 * stress, 0.45).unwrap();
    let weight = Vector3::new(0.0, 0.0, -1e-2) * (stress / length);
    let mut system = System::new();
    let body = system.add(Deformable::new(mesh, material, weight).unwrap());
    let stiff = |_: &Vector3<f64>, normal: &Vector3<f64>| if normal.z < 0.0 { stress / length } else { 0.0 };
    let bed = Springs::new(&system.bodies, body, stiff, |x| *x);
    system.others.push(Box::new(bed));
    let tip = Point3::new(at(1.0), at(2.0), at(28.0));
    let tube = Tube::straight(tip, Vector3::new(0.0, 0.1, 1.0), at(100.0), at(8.0)).unwrap();
    let contact = TubeContact::new(&system.bodies, body, tube, 10.0 * stress / length, |_, _| true).unwrap();
    system.tubes.push(contact);
    let mut a = system.initial();
    use simulation::space::solid::Solid;
    let _ = Solid::points(system.bodies.solid(0));
    let mut newton = newton(&system, 1e-8);
    let found = settle(&mut system, &mut newton, &mut a, &Tolerance::default());
    let found = found.unwrap();
    let force = system.tubes[0].force(&system.bodies, &a).force.z;
    (a.iter().map(|u| u / length).collect(), force / (stress * length * length), found.iterations)
}

#[test]
fn explore() {
    for length in [1.0, 1.1, 0.9, 3.0, 10.0, 0.7, 1e-3, 1e-6, 1e6] {
        println!("{length}");
        let r = std::panic::catch_unwind(|| scene(length, 1.0));
        if let Ok(r) = r { println!("{length} {} {}", r.1, r.2); }
    }
}

#[test]
fn units_change_nothing() {
    let (a, force, steps) = scene(1.0, 1.0);
    println!("{} unknowns, {force} {steps} steps", a.len());
    let most = a.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    for (length, stress) in [(2_f64.powi(-20), 2_f64.powi(30)), (2_f64.powi(20), 2_f64.powi(-20)), (1e-3, 1e6), (1e6, 1.0), (1e-6, 1.0), (1e-9, 1e3)] {
        let (b, other, n) = scene(length, stress);
        let off = a.iter().zip(&b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / most;
        println!("{length:e} {stress:e}: {n} steps, {off:e} {:e} {}", other / force - 1.0, a == b);
    }
}
