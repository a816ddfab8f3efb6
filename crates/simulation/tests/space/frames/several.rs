//! Several solids that one tube presses, of which none knows of another.

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::cells::{Mesh, Plane, Settings as Cells};
use simulation::space::frames::{Frames, NoFrames, Refused, Settings, State};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;

use super::{COARSE, largest};
use crate::block::{RADIUS, block, body, frames, pose, top, tube};

/// So tight that what is left is far below what is compared.
fn tight() -> Settings {
    Settings {
        tolerance: 1e-9,
        most_steps: 60,
        ..Settings::default()
    }
}

/// A cube of 50 mm that stands on its own ground 300 mm beside the block, as stiff as this, N/mm^2.
fn far(young: f64) -> Deformable {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    let corners = [Vector3::new(300.0, 0.0, 0.0), Vector3::new(350.0, 50.0, 50.0)];
    let mesh = Mesh::new(&everywhere, corners, &Cells::of_side(25.0), &|_, _| false).unwrap();
    let material = Material::new(Law::NeoHookean, young, 0.3).unwrap();
    Deformable::new(mesh, material, Vector3::zeros()).unwrap()
}

/// The block with another solid, which is held where it stands on its ground.
fn with(other: Deformable) -> System {
    let mut system = block(COARSE, 0.3);
    let held = other.mesh().nodes_where(|x| x.z < 1e-9);
    let offset = system.bodies.size();
    system.add(other);
    for n in held {
        (0..3).for_each(|k| system.fixed[offset + 3 * n + k] = true);
    }
    system
}

fn pressing(system: System, settings: Settings) -> Frames {
    let a = system.initial();
    let on_top = top(25.0);
    Frames::of_bodies(system, a, &[0, 1], tube(), settings, |_, at, n| on_top(at, n)).unwrap()
}

#[test]
fn a_solid_far_from_the_tube_stays_at_rest_to_the_bit_and_changes_nothing_of_the_other() {
    let (mut alone, mut both) = (frames(COARSE, 0.3, 25.0, tight()), pressing(with(far(5e-3)), tight()));
    for k in 1..=4 {
        let at = pose(f64::from(k), 0.5 * f64::from(k), 0.0);
        let [one, two] = [&mut alone, &mut both].map(|frames| frames.frame(&at));
        assert_eq!(
            (one.state, two.state),
            (State::Settled, State::Settled),
            "{one:?} {two:?}"
        );
        let (bodies, a) = (&both.system().bodies, both.state());
        assert!(bodies.part(1, a).iter().all(|u| *u == 0.0));
        // Both are in balance to 1e-9 of the forces of contact: in the order of that, of some millimetres.
        assert!(largest(bodies.part(0, a), alone.state()) < 1e-6);
        assert!((one.force.force - two.force.force).norm() < 1e-6 * one.force.force.norm());
    }
}

/// Force and moment are those of all solids together.
#[test]
fn two_solids_that_are_pressed_alike_press_twice_as_much() {
    let (mut alone, mut both) = (
        frames(COARSE, 0.3, 25.0, tight()),
        pressing(with(body(COARSE, 0.3)), tight()),
    );
    for k in 1..=3 {
        let at = pose(f64::from(k), 0.0, 0.02 * f64::from(k));
        let [one, two] = [&mut alone, &mut both].map(|frames| frames.frame(&at));
        assert_eq!((one.state, two.state), (State::Settled, State::Settled));
        let (bodies, a) = (&both.system().bodies, both.state());
        assert!(largest(bodies.part(0, a), bodies.part(1, a)) < 1e-6);
        assert!((two.force.force - 2.0 * one.force.force).norm() < 1e-6 * two.force.force.norm());
        // About a place on the tube's own axis moments are small: as a part of the force at an arm of the tube's radius.
        assert!((two.force.moment - 2.0 * one.force.moment).norm() < 1e-5 * two.force.force.norm() * RADIUS);
        assert!((two.energy - 2.0 * one.energy).abs() < 1e-6 * two.energy);
    }
}

/// Free forces were measured by those of contact on all solids: beside a stiff one, a soft one was called settled wherever it was.
#[test]
fn a_soft_solid_beside_a_stiff_one_is_settled_by_its_own_forces() {
    let soft = |scale: f64| {
        let mut system = System::new();
        let stiff = body(COARSE, 0.3);
        let material = Material::new(Law::NeoHookean, 5e-3 * scale, 0.3).unwrap();
        let soft = Deformable::new(stiff.mesh().clone(), material, Vector3::zeros()).unwrap();
        let held = stiff.mesh().nodes_where(|x| x.z < 1e-9);
        system.add(stiff);
        let offset = system.bodies.size();
        system.add(soft);
        for n in held {
            (0..3).for_each(|k| (system.fixed[3 * n + k], system.fixed[offset + 3 * n + k]) = (true, true));
        }
        pressing(system, Settings::default())
    };
    let mut frames = soft(1e-4);
    let mut settled = 0;
    for k in 1..=12 {
        let frame = frames.frame(&pose(0.5 * f64::from(k), 0.0, 0.0));
        if frame.state == State::Settled {
            settled += 1;
            // Of one geometry and one law, both lie alike: each to a thousandth of its own contact's forces, some hundredths of a millimetre by the
            // compliance of a block that is pressed by millimetres.
            let (bodies, a) = (&frames.system().bodies, frames.state());
            let off = largest(bodies.part(0, a), bodies.part(1, a));
            assert!(off < 0.05, "{k}: {off} mm");
        }
    }
    assert!(settled >= 6, "{settled}");
}

#[test]
fn a_state_that_is_denied_is_refused_and_the_one_before_it_stands() {
    let mut frames = frames(COARSE, 0.3, 25.0, Settings::default());
    assert_eq!(frames.frame(&pose(1.0, 0.0, 0.0)).state, State::Settled);
    let (before, tube) = (frames.state().to_vec(), *frames.tube().pose());
    let mut asked = Vec::new();
    let denied = frames.frame_where(&pose(2.0, 0.0, 0.0), |bodies, a| {
        asked = a.to_vec();
        bodies.len() == 2
    });
    assert_eq!(denied.state, State::Refused(Refused::Denied));
    assert!(asked != before && frames.state() == before && *frames.tube().pose() == tube);
    let on = frames.frame_where(&pose(2.0, 0.0, 0.0), |bodies, _| bodies.len() == 1);
    assert!(matches!(on.state, State::Settled | State::Approximate), "{on:?}");
    assert!(frames.state() != before);
}

#[test]
fn a_tube_comes_into_no_solid_that_it_may_not_press() {
    let system = with(body(COARSE, 0.3));
    let a = system.initial();
    let on_top = top(25.0);
    let frames = Frames::of_bodies(system, a, &[0], tube(), Settings::default(), |_, at, n| on_top(at, n));
    let refused = frames.unwrap().frame(&pose(1.0, 0.0, 0.0)).state;
    assert!(
        matches!(refused, State::Refused(Refused::OutOfReach { depth }) if depth > 0.1),
        "{refused:?}"
    );
    let system = with(far(5e-3));
    let a = system.initial();
    let none = Frames::of_bodies(system, a, &[0, 2], tube(), Settings::default(), |_, _, _| true);
    assert_eq!(none.map(|_| ()).unwrap_err(), NoFrames::NoBody { body: 2, solids: 2 });
}

/// What a soft solid is pushed by first was lost in what a stiff one bears: no step was found.
#[test]
fn a_soft_solid_is_followed_where_a_far_stiff_one_is_never_touched() {
    // A million times as stiff: its least force is far above what the block bears.
    let mut frames = pressing(with(far(5e3)), Settings::default());
    for k in 1..=4 {
        let frame = frames.frame(&pose(0.5 * f64::from(k), 0.0, 0.0));
        assert_eq!(frame.state, State::Settled, "{k}: {frame:?}");
        assert!(frame.force.force.norm() > 0.0);
    }
}
