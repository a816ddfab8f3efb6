//! How a settled state gives way to a parameter of the model, against states that are solved again with it moved.

use nalgebra::{Vector3, Vector6};
use simulation::control::Potential;
use simulation::law::Law;
use simulation::space::frames::{Frames, Settings, State};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::Springs;

use super::COARSE;
use crate::block::{HEIGHT, body, pose, top, tube};

const YOUNG: f64 = 5e-3;
const BED: f64 = 4e-4;
const PULL: f64 = 0.2;
/// What differences of states leave, of the change: found at most 5e-6, of Poisson's ratio.
const EXACT: f64 = 1e-5;

/// A block on an elastic bed in the place of a fixed ground, its top pulled aside so that it is not at rest where nothing presses.
fn system(young: f64, nu: f64, bed: f64) -> System {
    let mesh = body(COARSE, 0.3).mesh().clone();
    let material = Material::new(Law::NeoHookean, young, nu).unwrap();
    let mut system = System::new();
    system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
    let low = |at: &Vector3<f64>, _: &Vector3<f64>| if at.z < 1e-9 { bed } else { 0.0 };
    let springs = Springs::new(&system.bodies, 0, low, |at| *at);
    system.others.push(Box::new(springs));
    let pulled = mesh.nodes_where(|x| x.z > HEIGHT - 1e-9 && x.x > 25.0);
    let each = PULL / pulled.len() as f64;
    let loads: Vec<(usize, f64)> = pulled.iter().map(|n| (3 * n, each)).collect();
    System::load(&mut system, 0, &loads);
    system
}

/// Tight: states are compared with one another.
fn settings(refresh: f64) -> Settings {
    Settings {
        tolerance: 1e-9,
        depth: 1e-9,
        most_steps: 60,
        refresh,
        ..Settings::default()
    }
}

/// Pushed so deep, in steps; pulled alone where that is above it.
fn pushed(system: System, depth: f64, refresh: f64) -> Frames {
    let a = system.initial();
    let mut frames = Frames::new(system, a, 0, tube(), settings(refresh), top(25.0)).unwrap();
    for k in 1..=8 {
        // A way is made in parts, and ends within a few frames.
        let to = pose(depth * f64::from(k) / 8.0, 2.0, 0.02);
        let settled = (0..10).any(|_| frames.frame(&to).state == State::Settled);
        assert!(settled, "{k}");
    }
    frames
}

/// Places of the tissue whose change is compared, by the solid's own shares.
fn place(frames: &Frames, a: &[f64], at: Vector3<f64>) -> Vector3<f64> {
    let shares = frames.system().bodies.solid(0).shares(&at).unwrap();
    let each = shares.iter().map(|share| {
        let n = 3 * share.node as usize;
        Vector3::new(a[n], a[n + 1], a[n + 2]) * share.weight
    });
    each.sum()
}

fn forces(system: &System, a: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; a.len()];
    system.gradient(a, &mut gradient).unwrap();
    gradient.iter().map(|g| -g).collect()
}

/// By the implicit function theorem, and by solving again, for the logarithms of two stiffnesses and Poisson's ratio: the largest that places differ by, beside
/// the largest change.
fn compared(depth: f64, refresh: f64) -> Vec<[f64; 2]> {
    let nu = 0.42;
    let mut base = pushed(system(YOUNG, nu, BED), depth, refresh);
    let state = base.state().to_vec();
    let places = [
        (0.0, 0.0, 20.0),
        (5.0, 3.0, 12.0),
        (-20.0, 8.0, 40.0),
        (30.0, -30.0, 80.0),
    ];
    let places = places.map(|(x, y, below)| Vector3::new(x, y, HEIGHT - below));
    let of = |k: usize, by: f64| match k {
        0 => system(YOUNG * by.exp(), nu, BED),
        1 => system(YOUNG, nu, BED * by.exp()),
        _ => system(YOUNG, nu + by, BED),
    };
    // States are exact to about 1e-9 of their forces, and what differences leave goes with the square: of Poisson's ratio, by which stiffness grows
    // without bounds, a smaller one is best.
    let each = [2e-3, 2e-3, 1e-4].into_iter().enumerate().map(|(k, small)| {
        let [up, down] = [small, -small].map(|by| of(k, by));
        let (f, g) = (forces(&up, &state), forces(&down, &state));
        let slope: Vec<f64> = f.iter().zip(&g).map(|(f, g)| (f - g) / (2.0 * small)).collect();
        let found = base.yielding().unwrap().to(&slope).unwrap();
        let (pushed_by, found) = (found.on_tube, found.unknowns);
        let [up, down] = [up, down].map(|system| pushed(system, depth, refresh));
        let (mut off, mut most) = (0.0_f64, 0.0_f64);
        for at in places {
            let again = (place(&up, up.state(), at) - place(&down, down.state(), at)) / (2.0 * small);
            off = off.max((place(&base, &found, at) - again).norm());
            most = most.max(again.norm());
        }
        let [up, down] = [&up, &down].map(|frames| {
            let on_tube = frames.force();
            Vector6::from_iterator(on_tube.force.iter().chain(&on_tube.moment).copied())
        });
        let again = (up - down) / (2.0 * small);
        let off_force = (pushed_by - again).norm();
        assert!(
            off_force <= EXACT * again.norm(),
            "off by {off_force}: {pushed_by}{again}"
        );
        [off, most]
    });
    each.collect()
}

#[test]
fn a_state_without_contact_gives_way_as_states_do_that_are_solved_again() {
    for (k, [off, most]) in compared(-5.0, 1e-9).into_iter().enumerate() {
        println!("parameter {k}: off {off:.2e} of {most:.3} mm");
        assert!(most > 0.05 && off < EXACT * most, "parameter {k}: {off} of {most}");
    }
}

#[test]
fn a_state_in_contact_gives_way_as_states_do_that_are_solved_again() {
    // New factors at each frame, and old ones of 30 mm ago: what is asked for is of the state.
    for refresh in [1e-9, 1e3] {
        for (k, [off, most]) in compared(6.0, refresh).into_iter().enumerate() {
            println!("refresh {refresh}: parameter {k}: off {off:.2e} of {most:.3} mm");
            assert!(most > 0.05 && off < EXACT * most, "parameter {k}: {off} of {most}");
        }
    }
}
