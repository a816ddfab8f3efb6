//! Systems that several test files and the benchmark build.

use nalgebra::Vector2;
use simulation::control::{Minimum, Newton, Settings};
use simulation::law::{Law, Material};
use simulation::q9::grid;
use simulation::solid::Deformable;
use simulation::system::System;

/// A beam of 10 x 1, E = 1, clamped at x = 0, under its weight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    pub(crate) law: Law,
    pub(crate) poisson: f64,
    pub(crate) weight: f64,
    pub(crate) elements: [usize; 2],
    /// 1 for a uniform mesh; else elements shrink towards the clamped corners with this power.
    pub(crate) grading: f64,
}

/// `place` at the ends of `n` intervals, and half way between them at their middles.
fn halfway(t: f64, n: usize, place: impl Fn(f64) -> f64) -> f64 {
    let position = t * n as f64;
    let (low, high) = ((position + 1e-9).floor(), (position - 1e-9).ceil());
    0.5 * (place(low / n as f64) + place(high / n as f64))
}

pub(crate) fn beam(beam: Beam) -> System {
    let p = beam.grading;
    let along = |t: f64| 10.0 * t.powf(p);
    let across = |t: f64| {
        let (side, from_middle) = ((t - 0.5).signum(), 2.0 * (t - 0.5).abs());
        0.5 * side * (1.0 - (1.0 - from_middle).powf(p))
    };
    let [n, m] = beam.elements;
    let place = |s: f64, t: f64| Vector2::new(halfway(s, n, along), halfway(t, m, across));
    let mesh = grid(beam.elements, false, place).expect("a mesh");
    let clamped = mesh.nodes_where(|x| x.x == 0.0);
    let material = Material::new(beam.law, 1.0, beam.poisson).expect("a material");
    let solid = Deformable::new(mesh, material, Vector2::new(0.0, -beam.weight)).expect("a solid");
    let mut system = System::new();
    let body = system.add(solid);
    system.clamp(body, &clamped);
    system
}

/// The displacement of the middle of the free end, and the state.
pub(crate) fn cantilever(of: Beam) -> (Vector2<f64>, Minimum) {
    let mut system = beam(of);
    let [across, along] = of.elements;
    let (columns, row) = (2 * across + 1, along);
    let tip = row * columns + columns - 1;
    let (a, found) = settle(&mut system);
    (Vector2::new(a[2 * tip], a[2 * tip + 1]), found)
}

pub(crate) fn settle(system: &mut System) -> (Vec<f64>, Minimum) {
    let mut a = system.initial();
    let found = Newton::new(Settings::default())
        .minimise(system, &mut a)
        .expect("a state");
    (a, found)
}

/// Cook's membrane of n x n elements, and the node whose displacement is wanted.
pub(crate) fn cook(law: Law, poisson: f64, n: usize, mixed: bool) -> (System, usize) {
    let corners = [(0.0, 0.0), (48.0, 44.0), (48.0, 60.0), (0.0, 44.0)].map(|(x, y)| Vector2::new(x, y));
    let place = |s: f64, t: f64| {
        corners[0] * ((1.0 - s) * (1.0 - t))
            + corners[1] * (s * (1.0 - t))
            + corners[2] * (s * t)
            + corners[3] * ((1.0 - s) * t)
    };
    let mesh = grid([n, n], false, place).expect("a mesh");
    let mesh = if mixed { mesh.mixed() } else { mesh };
    let clamped = mesh.nodes_where(|x| x.x == 0.0);
    let traction = mesh.traction(Vector2::new(0.0, 6.25), |x| (x.x - 48.0).abs() < 1e-9);
    let material = Material::new(law, 240.565, poisson).expect("a material");
    let corner = mesh.nodes.len() - 1;
    let mut system = System::new();
    let body = system.add(Deformable::new(mesh, material, Vector2::zeros()).expect("a solid"));
    system.clamp(body, &clamped);
    system.load(body, &traction);
    (system, corner)
}
