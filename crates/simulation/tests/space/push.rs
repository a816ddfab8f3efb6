//! A block pushed by a tube with a round tip, against a second code's numbers.

use nalgebra::{Point3, Vector3};
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Plane, Settings};
use simulation::space::equilibrium::{Equilibrium, Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{TubeContact, TubeForce};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

/// Half the block's width, and its height, mm.
const HALF: f64 = 50.0;
const HEIGHT: f64 = 100.0;
const RADIUS: f64 = 10.0;
/// 5 kPa, in N/mm^2.
const YOUNG: f64 = 5e-3;
const STIFF: f64 = 60.0;

/// A tube whose tip is `depth` below the top of the block, in the middle of it.
fn tube(depth: f64) -> Tube {
    let tip = Point3::new(0.0, 0.0, HEIGHT - depth + RADIUS);
    Tube::straight(tip, Vector3::z(), 200.0, RADIUS).unwrap()
}

/// A quarter of the block, about the tube's axis.
fn quarter(settings: &Settings, nu: f64, fine: &[f64]) -> (System, usize) {
    let everywhere = Plane { point: Vector3::new(0.0, 0.0, 1e3), normal: Vector3::z() };
    let corners = [Vector3::zeros(), Vector3::new(HALF, HALF, HEIGHT)];
    let top = Vector3::new(0.0, 0.0, HEIGHT);
    let refine = |low: &Vector3<f64>, high: &Vector3<f64>| {
        let nearest = top.sup(low).inf(high);
        let level = (settings.side / (high.x - low.x)).log2().round() as usize;
        fine.get(level).is_some_and(|reach| (nearest - top).norm() < *reach)
    };
    let mesh = Mesh::new(&everywhere, corners, settings, &refine).unwrap();
    let material = Material::new(Law::NeoHookean, YOUNG, nu).unwrap();
    let solid = Deformable::new(mesh, material, Vector3::zeros()).unwrap();
    let mut held: Vec<usize> = (0..2)
        .flat_map(|k| solid.mesh().nodes_where(|x| x[k] < 1e-9).into_iter().map(move |n| 3 * n + k))
        .collect();
    held.extend(solid.mesh().nodes_where(|x| x.z < 1e-9).into_iter().flat_map(|n| [3 * n, 3 * n + 1, 3 * n + 2]));
    let mut system = System::new();
    let body = system.add(solid);
    held.iter().for_each(|i| system.fixed[*i] = true);
    let stiffness = STIFF * YOUNG / (settings.side / f64::powi(2.0, fine.len() as i32));
    let contact = TubeContact::new(&system.bodies, body, tube(0.0), stiffness, |_, normal| normal.z > 0.5);
    system.tubes.push(contact);
    (system, body)
}

/// States at depths, each from the one before.
fn push(settings: &Settings, nu: f64, fine: &[f64], depths: &[f64]) -> Vec<(f64, TubeForce, Equilibrium)> {
    let (mut system, _) = quarter(settings, nu, fine);
    let order = Dissection::by_places(&system.places(), &[]).unwrap();
    let control = Control { provisional: true, tolerance: 1e-7, ..Control::default() };
    let mut newton = Newton::ordered_by(control, order);
    let mut a = system.initial();
    let mut states = Vec::new();
    for depth in depths {
        system.tubes[0].move_to(tube(*depth));
        match settle(&mut system, &mut newton, &mut a, &Tolerance::default()) {
            Ok(found) => {
                let force = system.tubes[0].force(&system.bodies, &a);
                println!("{} unknowns, nu {nu}, {depth} mm: 4 F = {:.5} N, {found:.2?}", a.len(), 4.0 * force.force.z);
                states.push((*depth, force, found));
            }
            Err(failed) => println!("{} unknowns, nu {nu}, {depth} mm: {failed}", a.len()),
        }
    }
    states
}

#[test]
fn explore_push() {
    let depths: Vec<f64> = (1..=10).map(|k| 2.0 * f64::from(k)).collect();
    let start = std::time::Instant::now();
    push(&Settings { levels: 1, ..Settings::of_side(25.0) }, 0.49, &[30.0], &depths);
    println!("{:?}", start.elapsed());
    push(&Settings { levels: 2, ..Settings::of_side(25.0) }, 0.49, &[40.0, 25.0], &depths);
    println!("{:?}", start.elapsed());
}
