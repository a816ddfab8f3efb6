//! Points of the surface that only held nodes move: no pressure on them ends, so that none may begin.

use nalgebra::Vector3;
use simulation::space::frames::{Frames, NoFrames, Refused, Settings, State};
use simulation::space::system::System;
use simulation::space::tube::Tube;

use super::COARSE;
use crate::block::{HEIGHT, block, pose, top, tube};

/// The block with the nodes of its top held for which this holds.
fn held(which: impl Fn(&Vector3<f64>) -> bool) -> System {
    let mut system = block(COARSE, 0.45);
    let places = system.bodies.solid(0).places();
    for (node, place) in places.chunks_exact(3).enumerate() {
        let at = Vector3::from(place[0]);
        if at.z > HEIGHT - 1e-9 && which(&at) {
            system.fixed[3 * node..3 * node + 3].fill(true);
        }
    }
    system
}

/// How deep the deepest point is that only held nodes move, where the nodes with `x` below 1 are held, with the tip of a tube so deep.
fn deepest_held(system: &System, tube: &Tube) -> f64 {
    let solid = system.bodies.solid(0);
    let is_held = |point: &usize| {
        let row = solid.combination(*point).unwrap();
        row.iter().all(|(n, w)| *w == 0.0 || system.fixed[3 * *n as usize])
    };
    let each = (0..solid.points()).filter(is_held).map(|point| solid.reference(point));
    let on_top = each.filter(|(_, normal, _)| normal.z > 0.5);
    on_top.fold(f64::NEG_INFINITY, |deep, (at, ..)| {
        deep.max(-tube.signed_distance(&at).value)
    })
}

#[test]
fn a_held_point_in_the_tube_presses_with_no_invented_force_that_grows_from_frame_to_frame() {
    let system = held(|at| at.x < 1.0);
    let (aside, [mut low, mut high]) = (2.0, [0.0, 3.0]);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let there = tube().at(pose(middle, aside, 0.0)).unwrap();
        match deepest_held(&system, &there) < 5e-4 {
            true => low = middle,
            false => high = middle,
        }
    }
    let a = system.initial();
    let start = tube().at(pose(-1.0, aside, 0.0)).unwrap();
    let mut frames = Frames::new(system, a, 0, start, Settings::default(), top(25.0)).unwrap();
    for k in 1..=4 {
        frames.frame(&pose(low * f64::from(k) / 4.0, aside, 0.0));
    }
    let again: Vec<_> = (0..3).map(|_| frames.frame(&pose(low, aside, 0.0))).collect();
    for found in &again {
        assert_eq!(found.state, State::Settled, "{found:?}");
        assert_eq!(found.force, again[0].force);
        // A block of 5 kPa under a tube of 10 mm a little deep: 0.16 N; held points had hundreds.
        assert!(
            found.force.force.norm() > 0.05 && found.force.force.norm() < 0.5,
            "{found:?}"
        );
    }
    // Deeper than what a settled point may be there, it is said so.
    let deeper = frames.frame(&pose(low + 0.1, aside, 0.0));
    assert!(
        matches!(deeper.state, State::Refused(Refused::OutOfReach { .. })),
        "{deeper:?}"
    );
}

#[test]
fn many_points_that_nothing_moves_are_refused_by_name_and_not_by_a_panic() {
    let new = |reach: f64| {
        let system = held(|_| true);
        let a = system.initial();
        Frames::new(system, a, 0, tube(), Settings::default(), top(reach)).map(|_| ())
    };
    for reach in [9.0, 25.0] {
        assert_eq!(new(reach), Err(NoFrames::NoPoint { body: 0 }));
    }
    // More than a strip of them beside some that move.
    let system = held(|at| at.x < 1.0);
    let a = system.initial();
    let start = tube().at(pose(-1.0, -12.0, 0.0)).unwrap();
    let mut frames = Frames::new(system, a, 0, start, Settings::default(), top(50.0)).unwrap();
    let above = frames.frame(&pose(-0.1, -12.0, 0.0));
    assert_eq!((above.state, above.force.points), (State::Settled, 0));
    let below = frames.frame(&pose(1.0, -12.0, 0.0));
    assert!(
        matches!(below.state, State::Refused(Refused::OutOfReach { .. })),
        "{below:?}"
    );
}
