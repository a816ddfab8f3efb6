//! Oriented particles against cubes of 27 nodes: unknowns, time and error of one case.
//!
//! `cargo bench -p simulation --bench particles [-- ROWS]`. A block of 100 mm (5 kPa, Poisson's ratio 0.49) on a stiff bed, a round tube of 20 mm pushed 20 mm into
//! its top in steps of 2.5 mm. Force against 1.6371 N, to which a second code converges (tests/space/push.rs), displacements against a finer mesh of the
//! quarter: the largest difference within 15 mm of the tip, and anywhere. `ROWS`, a comma between, names rows to be run, all by default.

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
const STEPS: i32 = 8;
/// N, of a second code.
const FORCE: f64 = 1.6371;
/// N/mm^3: 2000 times what the block gives way by.
const BED: f64 = 0.1;
/// Of the particles, in sides of their cubes.
const REACH: f64 = 1.3;

fn tube(depth: f64) -> Tube {
    let tip = Point3::new(0.0, 0.0, HEIGHT - depth + RADIUS);
    Tube::straight(tip, Vector3::z(), 200.0, RADIUS).unwrap()
}

/// Cubes of this side, halved within each of `fine` of the middle of the top.
fn mesh(low: [f64; 3], side: f64, fine: &[f64]) -> Mesh {
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
    let corners = [low.into(), Vector3::new(HALF, HALF, HEIGHT)];
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

/// Pushes the tube in, in steps.
fn pushed(mut system: System) -> Result<Found, String> {
    let begin = processor();
    let contact = TubeContact::new(&system.bodies, 0, tube(0.0), 0.05, |_, n| n.z > 0.5);
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

/// How places move: in the quarter, below the tube and all over.
fn moves(found: &Found) -> Vec<(bool, Vector3<f64>)> {
    let solid = found.system.bodies.solid(0);
    let steps = [2.0, 6.0, 12.0, 20.0, 30.0, 45.0];
    let places = steps.iter().flat_map(|x| steps.map(move |y| [*x, y]));
    let places =
        places.flat_map(|[x, y]| [1.0, 5.0, 10.0, 20.0, 40.0, 70.0].map(|below| Vector3::new(x, y, HEIGHT - below)));
    let each = places.map(|at| {
        let near = (at - Vector3::new(0.0, 0.0, HEIGHT)).norm() < 15.0;
        let shares = solid.shares(&at).unwrap();
        let moved = shares.iter().map(|s| {
            let n = 3 * s.node as usize;
            Vector3::from_column_slice(&found.a[n..n + 3]) * s.weight
        });
        (near, moved.sum())
    });
    each.collect()
}

/// By the finest mesh: a quarter, its planes of symmetry held.
fn reference() -> Vec<(bool, Vector3<f64>)> {
    let mesh = mesh([0.0; 3], 12.5, &[45.0, 22.0]);
    let held: Vec<usize> = (0..2)
        .flat_map(|k| mesh.nodes_where(|x| x[k] < 1e-9).into_iter().map(move |n| 3 * n + k))
        .collect();
    let mut system = on_bed(Deformable::new(mesh, material(), Vector3::zeros()).unwrap());
    held.into_iter().for_each(|i| system.fixed[i] = true);
    let found = pushed(system).unwrap();
    println!(
        "reference: {} unknowns, {:.4} N, {} steps, {:.0} s",
        found.a.len(),
        4.0 * found.force,
        found.steps,
        found.seconds
    );
    moves(&found)
}

fn say(name: &str, system: System, exact: &[(bool, Vector3<f64>)]) {
    let found = match pushed(system) {
        Ok(found) => found,
        Err(refused) => return println!("| {name} | {refused} |"),
    };
    let mut most = [0.0_f64; 2];
    for ((near, moved), (_, exact)) in moves(&found).iter().zip(exact) {
        let off = (moved - exact).norm();
        most[1] = most[1].max(off);
        most[0] = if *near { most[0].max(off) } else { most[0] };
    }
    println!(
        "| {name} | {} | {:.4} ({:+.2} %) | {:.2} / {:.2} | {} | {:.1} |",
        found.a.len(),
        found.force,
        100.0 * (found.force / FORCE - 1.0),
        most[0],
        most[1],
        found.steps,
        found.seconds
    );
}

fn main() {
    say_load();
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|word| word == name);
    let low = [-HALF, -HALF, 0.0];
    let exact = reference();
    println!(
        "| row | unknowns | force, N | off near the tip / anywhere, mm | steps | s of processors |\n|---|---|---|---|---|---|"
    );
    let graded: &[f64] = &[40.0, 20.0];
    for (side, fine) in [(25.0, &[] as &[f64]), (50.0 / 3.0, &[]), (12.5, &[]), (25.0, graded)] {
        let name = format!("{side:.3}{}", if fine.is_empty() { "" } else { " and finer" });
        if wanted("mesh") {
            let solid = Deformable::new(mesh(low, side, fine), material(), Vector3::zeros()).unwrap();
            say(&format!("cubes, {name}"), on_bed(solid), &exact);
        }
        // Cubes of half the distance: those of the whole leave 1 % of a strain.
        let halved: Vec<f64> = fine.to_vec();
        if wanted("particles") {
            let particles = Particle::of_cubes(&mesh(low, side, fine), REACH);
            let points = mesh(low, 0.5 * side, &halved);
            match Particles::new(&points, material(), Vector3::zeros(), &particles) {
                Ok(solid) => say(&format!("particles, {name}"), on_bed(solid), &exact),
                Err(refused) => println!("| particles, {name} | {refused} |"),
            }
        }
    }
}
