//! Several solids that one tube presses, each followed by frames of its own.

use nalgebra::{Isometry3, Vector3};
use simulation::law::Law;
use simulation::space::frames::{Frames, Refused, Settings, State, Together};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;

use super::COARSE;
use crate::block::{body, pose, top, tube};

/// The block with this stiffness, N/mm^2, on its ground, added to a system.
fn add(system: &mut System, young: f64) {
    let mesh = body(COARSE, 0.3).mesh().clone();
    let held = mesh.nodes_where(|x| x.z < 1e-9);
    let material = Material::new(Law::NeoHookean, young, 0.3).unwrap();
    let offset = system.bodies.size();
    system.add(Deformable::new(mesh, material, Vector3::zeros()).unwrap());
    for n in held {
        (0..3).for_each(|k| system.fixed[offset + 3 * n + k] = true);
    }
}

fn system(youngs: &[f64]) -> System {
    let mut system = System::new();
    youngs.iter().for_each(|young| add(&mut system, *young));
    system
}

/// One block alone, of which the tube may press so much of the top.
fn alone(young: f64, reach: f64) -> Frames {
    let system = system(&[young]);
    let a = system.initial();
    Frames::new(system, a, 0, tube(), Settings::default(), top(reach)).unwrap()
}

const YOUNGS: [f64; 2] = [5e-3, 2e-3];

fn together(reaches: [f64; 2]) -> Together {
    let each = [0, 1].map(|k| alone(YOUNGS[k], reaches[k])).into();
    Together::new(system(&YOUNGS), each).unwrap()
}

fn far() -> Isometry3<f64> {
    pose(-30.0, 0.0, 0.0)
}

#[test]
fn each_solid_has_the_bits_that_it_has_alone_and_the_frame_tells_the_worst_and_the_sum() {
    let mut both = together([25.0; 2]);
    let mut each = YOUNGS.map(|young| alone(young, 25.0));
    for k in 1..=8 {
        let at = pose(0.7 * f64::from(k), 0.2, 0.01);
        let found = both.frame_where(&at, |_, _| true);
        let frames = each.each_mut().map(|one| one.frame(&at));
        let states: Vec<f64> = each.iter().flat_map(|one| one.state().to_vec()).collect();
        assert_eq!(both.state(), states, "{k}");
        let [one, two] = &frames;
        assert_eq!(found.residual, one.residual.max(two.residual));
        assert_eq!(found.force.force, one.force.force + two.force.force);
        assert_eq!(both.force().points, one.force.points + two.force.points);
        assert_eq!(found.factor, one.factor + two.factor);
        let settled = frames.iter().all(|frame| frame.state == State::Settled);
        assert_eq!(found.state == State::Settled, settled, "{found:?}");
    }
    // Drawn back to where nothing presses they are at rest, to the bit.
    assert!(!both.is_free() && both.rest(&pose(3.0, 0.0, 0.0)).is_none() && both.is_clear(&far()));
    let free = both.rest(&far()).unwrap();
    assert_eq!((free.state, free.force.points), (State::Settled, 0));
    assert!(both.state().iter().all(|u| *u == 0.0) && both.is_free());
}

/// Where one cannot follow, or others deny what all came to, none has moved.
#[test]
fn a_pose_that_one_solid_refuses_or_others_deny_moves_none() {
    // The second has contact prepared hardly anywhere: aside, the tube comes into its surface.
    let mut both = together([45.0, 8.0]);
    assert_eq!(
        both.frame_where(&pose(1.0, 0.0, 0.0), |_, _| true).state,
        State::Settled
    );
    let (before, tube) = (both.state().to_vec(), *both.tube().pose());
    let aside = both.frame_where(&pose(2.0, 10.0, 0.0), |_, _| true);
    assert!(
        matches!(aside.state, State::Refused(Refused::OutOfReach { .. })),
        "{aside:?}"
    );
    assert!(both.state() == before && *both.tube().pose() == tube);
    let denied = both.frame_where(&pose(1.5, 0.0, 0.0), |bodies, a| bodies.len() == 2 && a == before);
    assert_eq!(denied.state, State::Refused(Refused::Denied));
    assert!(both.state() == before && *both.tube().pose() == tube);
    assert_eq!(
        both.frame_where(&pose(1.5, 0.0, 0.0), |_, a| a != before).state,
        State::Settled
    );
}

#[test]
fn what_small_forces_do_is_what_they_do_to_each() {
    let mut both = together([25.0; 2]);
    let mut each = YOUNGS.map(|young| alone(young, 25.0));
    let at = pose(1.0, 0.0, 0.0);
    both.frame_where(&at, |_, _| true);
    each.iter_mut()
        .for_each(|one| assert_eq!(one.frame(&at).state, State::Settled));
    let size = both.state().len() / 2;
    let mut forces = vec![vec![0.0; 2 * size]; 2];
    // On the first alone, and on both.
    (forces[0][size - 1], forces[1][size - 1], forces[1][2 * size - 4]) = (1e-3, 1e-3, -2e-3);
    let found = both.changes(&forces).unwrap();
    for (change, forces) in found.iter().zip(&forces) {
        let parts = [&forces[..size], &forces[size..]];
        let mut on_tube = nalgebra::Vector6::zeros();
        for (k, part) in parts.into_iter().enumerate() {
            let own = each[k].yielding().unwrap().to(part).unwrap();
            assert_eq!(change.unknowns[k * size..(k + 1) * size], own.unknowns[..]);
            on_tube += own.on_tube;
        }
        assert!((change.on_tube - on_tube).norm() <= 1e-12 * on_tube.norm());
    }
    assert!(found[0].unknowns[size..].iter().all(|u| *u == 0.0));
}

#[test]
fn frames_of_other_solids_than_the_system_has_are_none_together() {
    let each = |count: usize| (0..count).map(|k| alone(YOUNGS[k], 25.0)).collect::<Vec<_>>();
    assert!(
        Together::new(system(&YOUNGS), each(1)).is_none() && Together::new(system(&YOUNGS[..1]), each(2)).is_none()
    );
    assert!(Together::new(System::new(), Vec::new()).is_none());
}
