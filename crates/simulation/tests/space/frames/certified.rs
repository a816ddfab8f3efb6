//! What must not be called settled, nor begun with: each was once.

use nalgebra::{Isometry3, Point3, Vector3};
use simulation::space::cells::Ball;
use simulation::space::frames::{Frames, NoFrames, Refused, Settings, State};
use simulation::space::solid::Deformable;
use simulation::space::term::{ObstacleContact, TubeContact};
use simulation::space::tube::Tube;

use super::{COARSE, bone};
use crate::block::{Grid, HEIGHT, block, body, frames, pose, top};
use crate::contact::obstacle::surface;

#[test]
fn a_start_in_a_surface_without_contact_is_refused() {
    // Through the side, and wholly inside with no point of the surface in it.
    for x in [45.0, 30.0] {
        let system = block(COARSE, 0.45);
        let a = system.initial();
        let tube = Tube::straight(Point3::new(x, 0.0, 60.0), Vector3::x(), 60.0, 10.0).unwrap();
        let found = Frames::new(system, a, 0, tube, Settings::default(), top(25.0)).map(|_| ());
        let refused = matches!(
            found,
            Err(NoFrames::Start(Refused::OutOfReach { .. } | Refused::TooCoarse { .. }) | NoFrames::TooDeep { .. })
        );
        assert!(refused, "{x}: {found:?}");
    }
}

#[test]
fn tissue_in_bone_where_no_contact_with_it_was_prepared_is_refused() {
    // Contact with bone to one side only: the tube presses the rest into it.
    let system = bone::layer_on(|x, n| n.z < -0.5 && x.x < -12.0, 0.0, 5e-5);
    let a = system.initial();
    let mut frames = Frames::new(system, a, 0, bone::tube(), Settings::default(), bone::on_top).unwrap();
    let states: Vec<State> = (1..=24)
        .map(|k| frames.frame(&bone::pose(f64::from(k) / 4.0)).state)
        .collect();
    let refused = states
        .iter()
        .position(|s| matches!(s, State::Refused(Refused::OutOfReach { .. })));
    assert!(refused.is_some_and(|k| k > 3), "{states:?}");
    // What is there is a state before that: nothing lies in bone.
    let ball = surface(
        Ball {
            centre: Vector3::new(0.0, 0.0, -41.0),
            radius: 40.0,
        },
        15.0,
    );
    let all = ObstacleContact::new(&frames.system().bodies, 0, ball, 0.01, |_, _| true).unwrap();
    assert!(all.depth(&frames.system().bodies, frames.state()) <= 1e-3);
}

#[test]
fn a_settled_surface_is_not_drawn_apart_and_its_cubes_near_the_tube_are_not_inside_out() {
    const FINE: Grid = Grid {
        side: 25.0,
        fine: &[30.0, 15.0],
    };
    let thin = Tube::straight(Point3::origin(), Vector3::z(), 200.0, 5.0).unwrap();
    let at = |depth: f64| Isometry3::translation(0.0, 0.0, HEIGHT - depth + 5.0);
    let system = block(FINE, 0.45);
    let (a, start) = (system.initial(), thin.at(at(0.0)).unwrap());
    let mut frames = Frames::new(system, a, 0, start, Settings::default(), top(20.0)).unwrap();
    let mesh: Deformable = body(FINE, 0.45);
    let (mut inverted, mut last) = (0, State::Approximate);
    for k in 1..=57 {
        let found = frames.frame(&at(f64::from(k) / 3.0));
        let contact = TubeContact::new(&frames.system().bodies, 0, frames.tube().clone(), 0.03, top(20.0)).unwrap();
        let gap = contact.widest_gap(&frames.system().bodies, frames.state());
        let (_, reached) = mesh.bounded_determinant(frames.state());
        last = found.state;
        if last == State::Settled {
            // Places are summed in another order.
            assert!(
                found.gap >= gap * (1.0 - 1e-12) && found.gap <= 2.5 && reached > 0.0,
                "{k}: {found:?} {gap} {reached}"
            );
        }
        inverted += usize::from(reached <= 0.0 || gap > 2.5);
        if matches!(last, State::Refused(_)) {
            break;
        }
    }
    println!("{inverted} states not to be settled, the last {last:?}");
    // The way goes to where it could not be said any more.
    assert!(last != State::Settled);
}

#[test]
fn there_is_no_stiffness_outside_of_settled_states() {
    let mut all = frames(COARSE, 0.45, 25.0, Settings::default());
    let far = all.frame(&pose(100.0, 0.0, 0.0));
    assert!(matches!(far.state, State::CatchingUp { .. }), "{far:?}");
    assert!(all.yielding().is_none());
}

#[test]
fn free_forces_are_measured_by_the_tube_where_bone_carries_far_more() {
    // First contact of the tube with a heavy layer that lies on bone.
    let [usual, strict] = [1e-3, 1e-8].map(|tolerance| {
        let system = bone::layer_on(|_, n| n.z < -0.5, 2e-4, 5e-4);
        let a = system.initial();
        let settings = Settings {
            tolerance,
            depth: tolerance.min(1e-4),
            most_steps: 60,
            least_force: Some(1e-6),
            ..Settings::default()
        };
        let above = bone::tube().at(bone::pose(-40.0)).unwrap();
        let mut frames = Frames::new(system, a, 0, above, settings, bone::on_top).unwrap();
        for _ in 0..12 {
            frames.frame(&bone::pose(0.0));
        }
        // It sags before the tube comes to it: the first frames in which the tube presses.
        let each = (0..200).map(|k| {
            let found = frames.frame(&bone::pose(f64::from(k) / 10.0));
            let bone = frames.bone_force(0).unwrap().force.norm();
            (found.state == State::Settled, found.force.force.norm(), bone)
        });
        each.scan(0, |pressed, found| {
            *pressed += usize::from(found.1 > 0.0);
            (*pressed < 6).then_some(found)
        })
        .collect::<Vec<_>>()
    });
    let mut light = 0;
    for (k, (found, truth)) in usual.iter().zip(&strict).enumerate() {
        if found.0 && truth.0 && truth.1 > 0.0 {
            let off = (found.1 - truth.1).abs() / truth.1;
            println!("{k}: tube {:.5}, bone {:.3}, off by {off:.1e}", truth.1, truth.2);
            light += usize::from(truth.1 < 0.05 * truth.2);
            assert!(off < 0.02, "{k}: {off}");
        }
    }
    assert!(light > 0);
}

#[test]
fn a_refusal_before_any_frame_tells_the_residual_of_the_start() {
    // Heavier than its springs hold it at the start.
    let system = bone::layer_on(|_, n| n.z < -0.5, 1e-4, 5e-4);
    let a = system.initial();
    let mut frames = Frames::new(system, a, 0, bone::tube(), Settings::default(), bone::on_top).unwrap();
    let mut bad = bone::pose(0.0);
    bad.translation.x = f64::NAN;
    let found = frames.frame(&bad);
    assert_eq!(found.state, State::Refused(Refused::Pose));
    assert!(found.residual > 1e-3 && found.unsettled > 0.0, "{found:?}");
    assert!(frames.yielding().is_none());
}
