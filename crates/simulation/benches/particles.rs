//! Oriented particles against cubes of 27 nodes: unknowns, time and error of one case.
//!
//! `cargo bench -p simulation --bench particles [-- cubes|particles]`. A block of 100 mm (5 kPa, Poisson's ratio 0.49) on a stiff bed, a round tube of 20 mm pushed 20 mm
//! into its top in steps of 2 mm. Force and displacements of eight places against those of a second code (tests/space/push.rs): 1.6371 N, the largest
//! difference of the four places within 25 mm of the tip's first touch, and of the others.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

mod shared;

use nalgebra::{Point3, Vector3};
use shared::say_load;
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Plane, Settings};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Particle, Particles, Solid};
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

const HALF: f64 = 50.0;
const HEIGHT: f64 = 100.0;
const RADIUS: f64 = 10.0;
const YOUNG: f64 = 5e-3;
const DEPTH: f64 = 20.0;
const STEPS: i32 = 10;
/// N, of a second code.
const FORCE: f64 = 1.6371;
/// N/mm^3: 2000 times what the block gives way by.
const BED: f64 = 0.1;
/// Places and where the second code's finest mesh moves them, mm; the first four are near the tip.
const MOVED: [([f64; 3], [f64; 3]); 8] = [
    ([0.0, 0.0, 80.0], [0.0, 0.0, -7.7390]),
    ([0.0, 0.0, 90.0], [0.0, 0.0, -12.6603]),
    ([10.0, 0.0, 95.0], [2.7113, 0.0, -7.9044]),
    ([20.0, 0.0, 90.0], [1.4746, 0.0, -3.9208]),
    ([0.0, 0.0, 20.0], [0.0, 0.0, -0.4243]),
    ([0.0, 0.0, 40.0], [0.0, 0.0, -1.4900]),
    ([0.0, 0.0, 60.0], [0.0, 0.0, -3.3835]),
    ([0.0, 30.0, 60.0], [0.0, 1.2044, -2.0081]),
];
/// Of the particles, in sides of their cubes.
const REACH: f64 = 1.3;

fn tube(depth: f64) -> Tube {
    let tip = Point3::new(0.0, 0.0, HEIGHT - depth + RADIUS);
    Tube::straight(tip, Vector3::z(), 200.0, RADIUS).unwrap()
}

/// Cubes of this side, halved within each of `fine` of the middle of the top.
fn mesh(side: f64, fine: &[f64]) -> Mesh {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    let top = Vector3::new(0.0, 0.0, HEIGHT);
    let refine = |low: &Vector3<f64>, high: &Vector3<f64>| {
        let level = (side / (high.x - low.x)).log2().round() as usize;
        let nearest = top.sup(low).inf(high);
        fine.get(level).is_some_and(|reach| (nearest - top).norm() < *reach)
    };
    let settings = Settings {
        levels: fine.len() as u32,
        ..Settings::of_side(side)
    };
    let corners = [Vector3::new(-HALF, -HALF, 0.0), Vector3::new(HALF, HALF, HEIGHT)];
    Mesh::new(&everywhere, corners, &settings, &refine).unwrap()
}

fn material() -> Material {
    Material::new(Law::NeoHookean, YOUNG, 0.49).unwrap()
}

/// Seconds of processors that this process took: what else runs is not in it.
fn processor() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// A state, and what it took.
struct Found {
    system: System,
    a: Vec<f64>,
    force: f64,
    steps: usize,
    seconds: f64,
}

/// Pushes the tube in, in steps, with contact as stiff as cubes of the smallest side ask for.
fn pushed(mut system: System, side: f64) -> Result<Found, String> {
    let begin = processor();
    let contact = TubeContact::new(&system.bodies, 0, tube(0.0), 60.0 * YOUNG / side, |_, n| n.z > 0.5);
    system.tubes.push(contact.unwrap());
    let control = Control {
        provisional: true,
        tolerance: 1e-8,
        ..Control::default()
    };
    let order = Dissection::by_places(&system.places(), &[]).unwrap();
    let mut newton = Newton::ordered_by(control, order);
    let (mut a, mut steps) = (system.initial(), 0);
    for k in 1..=STEPS {
        system.tubes[0].move_to(tube(DEPTH * f64::from(k) / f64::from(STEPS)));
        let found = settle(&mut system, &mut newton, &mut a, &Tolerance::default());
        steps += found.map_err(|refused| format!("step {k}: {refused}"))?.iterations;
    }
    let force = system.tubes[0].force(&system.bodies, &a).force.z;
    let seconds = processor() - begin;
    Ok(Found {
        system,
        a,
        force,
        steps,
        seconds,
    })
}

/// A solid on the bed.
fn on_bed(solid: impl Solid + 'static) -> System {
    let mut system = System::new();
    system.add(solid);
    let bed = Springs::new(&system.bodies, 0, |x, _| if x.z < 1e-9 { BED } else { 0.0 }, |x| *x);
    system.others.push(Box::new(bed));
    system
}

/// How far the places are off, near the tip and elsewhere.
fn off(found: &Found) -> [f64; 2] {
    let solid = found.system.bodies.solid(0);
    let each = MOVED.map(|(at, exact)| {
        let shares = solid.shares(&at.into()).unwrap();
        let moved = shares.iter().map(|s| {
            let n = 3 * s.node as usize;
            Vector3::from_column_slice(&found.a[n..n + 3]) * s.weight
        });
        (moved.sum::<Vector3<f64>>() - Vector3::from(exact)).norm()
    });
    let (near, others) = each.split_at(4);
    [near, others].map(|of| of.iter().copied().fold(0.0, f64::max))
}

fn say(name: &str, system: System, side: f64) {
    let unknowns = system.initial().len();
    match pushed(system, side) {
        Err(refused) => println!("| {name} | {unknowns} | {refused} | | | |"),
        Ok(found) => {
            let [near, others] = off(&found);
            println!(
                "| {name} | {unknowns} | {:.4} ({:+.2} %) | {near:.3}, {others:.3} | {} | {:.1} |",
                found.force,
                100.0 * (found.force / FORCE - 1.0),
                found.steps,
                found.seconds
            );
        }
    }
}

fn main() {
    say_load();
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|word| word == name);
    println!(
        "| row | unknowns | force, N | off near the tip, elsewhere, mm | steps | s of processors |\n|---|---|---|---|---|---|"
    );
    let rows: [(f64, &[f64]); 6] = [
        (25.0, &[30.0]),
        (25.0, &[40.0, 25.0]),
        (50.0 / 3.0, &[]),
        (50.0 / 3.0, &[30.0]),
        (12.5, &[]),
        (12.5, &[25.0]),
    ];
    for (side, fine) in rows {
        let smallest = side / f64::from(1 << fine.len());
        let name = format!("{side:.1} mm, {smallest:.1} near the tip");
        if wanted("cubes") {
            let solid = Deformable::new(mesh(side, fine), material(), Vector3::zeros()).unwrap();
            say(&format!("cubes of {name}"), on_bed(solid), smallest);
        }
        if wanted("particles") {
            let particles = Particle::of_cubes(&mesh(side, fine), REACH);
            // Integrated in cubes half as large: those of the particles' distance leave 1 % of a strain.
            let solid = Particles::new(&mesh(0.5 * side, fine), material(), Vector3::zeros(), &particles);
            say(&format!("particles at {name}"), on_bed(solid.unwrap()), 0.5 * smallest);
        }
    }
}
