//! One scene in other units.

use nalgebra::{Point3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Field, Mesh, Settings};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;

use crate::common::{everywhere, newton};

/// Displacements by the unit of length, and the force by those of length and stress, of a region of cubes of 11 or 10 on a bed
/// with a tube in its top.
fn scene(region: &dyn Field, [low, high, side]: [f64; 3], [length, stress]: [f64; 2]) -> (Vec<f64>, f64) {
    let at = |x: f64| x * length;
    let corners = [Vector3::repeat(at(low)), Vector3::repeat(at(high))];
    let mesh = Mesh::new(region, corners, &Settings::of_side(at(side)), &|_, _| false).unwrap();
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
    let (mut a, mut newton) = (system.initial(), newton(&system, 1e-8));
    settle(&mut system, &mut newton, &mut a, &Tolerance::default()).unwrap();
    let force = system.tubes[0].force(&system.bodies, &a).force.z;
    (
        a.iter().map(|u| u / length).collect(),
        force / (stress * length * length),
    )
}

fn ball(units: [f64; 2]) -> (Vec<f64>, f64) {
    let ball = Ball {
        centre: Vector3::new(1.0, 2.0, 3.0) * units[0],
        radius: 20.0 * units[0],
    };
    scene(&ball, [-20.0, 24.0, 11.0], units)
}

fn block(units: [f64; 2]) -> (Vec<f64>, f64) {
    scene(&everywhere(1e3 * units[0]), [-17.0, 23.0, 10.0], units)
}

#[test]
fn powers_of_two_change_no_bit() {
    let here = ball([1.0, 1.0]);
    // A scale of stiffness that was no stiffness shifted matrices of small solids by too much: no convergence.
    for units in [[-20, 30], [20, -20]] {
        let there = ball(units.map(|p| 2_f64.powi(p)));
        assert!(here == there, "{units:?}: {} {}", here.1, there.1);
    }
}

#[test]
fn other_units_change_rounding_only() {
    let here = block([1.0, 1.0]);
    let most = here.0.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    // Metres and pascals; 1e-6 to 1e6 of both.
    for units in [[1e-3, 1e6], [1e-6, 1e6], [1e6, 1e-6], [1e6, 1e6]] {
        let there = block(units);
        let off = here.0.iter().zip(&there.0).map(|(x, y)| (x - y).abs());
        let off = [off.fold(0.0, f64::max) / most, (there.1 / here.1 - 1.0).abs()];
        println!("{units:?}: displacement and force differ by {off:?}");
        // As many steps, each of some thousand roundings.
        assert!(off.iter().all(|o| *o < 1e-11), "{units:?} {off:?}");
    }
}

#[test]
fn a_search_among_energies_that_cancel() {
    // At this scale rounding made no energy seem to fall, and steps of 1e-14 were made to the end: the energy is a fortieth of
    // the work of the weight in it. Forces of cut cubes differ by their points, which rounding chooses.
    let [here, there] = [1.0, 1.1].map(|length| ball([length, 1.0]).1);
    println!("{here} {there}");
    assert!((there / here - 1.0).abs() < 0.01);
}
