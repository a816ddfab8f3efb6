//! Poses and systems that frames refuse.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use simulation::space::frames::{Frames, NoFrames, Refused, Settings, State};
use simulation::space::system::System;
use simulation::space::term::{ObstacleContact, OrganContact, TubeContact};
use simulation::space::tube::Tube;

use super::{COARSE, pushed};
use crate::block::{block, frames, pose, top, tube};
use crate::contact::obstacle::{below, surface};

#[test]
fn poses_that_are_none_and_places_without_contact_are_refused_and_leave_the_state() {
    let mut frames = frames(COARSE, 0.45, 10.0, Settings::default());
    pushed(&mut frames, 1..=3);
    let before = frames.state().to_vec();
    let mut bad = pose(1.0, 0.0, 0.0);
    bad.translation = Translation3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(frames.frame(&bad).state, State::Refused(Refused::Pose));
    bad = Isometry3::from_parts(
        pose(1.0, 0.0, 0.0).translation,
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f64::NAN, 0.0, 0.0, 0.0)),
    );
    assert_eq!(frames.frame(&bad).state, State::Refused(Refused::Pose));
    // Twice as long a quaternion would make a tube out of shape.
    let double = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(2.0, 0.0, 0.0, 0.0));
    bad = Isometry3::from_parts(pose(1.0, 0.0, 0.0).translation, double);
    assert_eq!(frames.frame(&bad).state, State::Refused(Refused::Pose));
    let far = frames.frame(&pose(1e30, 0.0, 0.0));
    assert_eq!(far.state, State::Refused(Refused::Pose));
    // The numbers of a refusal are those of the state that is there.
    assert!(far.residual > 0.0 && far.force == frames.force());
    // Only what is within 10 mm of the middle was named: 25 mm beside it the tube presses what is not.
    let aside = (1..=60).map(|k| frames.frame(&pose(2.0, 0.5 * f64::from(k), 0.0)));
    let refused = aside
        .map(|frame| frame.state)
        .find(|state| matches!(state, State::Refused(_)));
    assert!(
        matches!(refused, Some(State::Refused(Refused::OutOfReach { depth })) if depth > 0.0),
        "{refused:?}"
    );
    assert!(frames.state() != before);
    let kept = frames.state().to_vec();
    let again = frames.frame(&pose(2.0, 30.0, 0.0));
    assert!(matches!(again.state, State::Refused(_)));
    assert_eq!(frames.state(), kept);
    let back = (0..200)
        .map(|_| frames.frame(&pose(1.0, 0.0, 0.0)).state)
        .find(|state| *state == State::Settled);
    assert!(back.is_some());
}

#[test]
fn systems_that_have_no_frames_are_refused_by_name() {
    let new = |change: &dyn Fn(&mut System), settings: Settings, reach: f64| {
        let mut system = block(COARSE, 0.45);
        change(&mut system);
        let a = system.initial();
        Frames::new(system, a, 0, tube(), settings, top(reach))
            .map(|_| ())
            .unwrap_err()
    };
    let usual = Settings::default();
    let with_tube = |system: &mut System| {
        let contact = TubeContact::new(&system.bodies, 0, tube(), 0.03, top(25.0)).unwrap();
        system.tubes.push(contact);
    };
    assert_eq!(new(&with_tube, usual, 25.0), NoFrames::Tubes { found: 1 });
    let with_term = |system: &mut System| {
        let contact = TubeContact::new(&system.bodies, 0, tube(), 0.03, top(25.0)).unwrap();
        system.others.push(Box::new(contact));
    };
    assert_eq!(new(&with_term, usual, 25.0), NoFrames::Changing { term: 0 });
    let with_organ = |system: &mut System| {
        let organ = OrganContact::new(&system.bodies, [0, 0], surface(below(-5.0), 10.0), 0.03, |_, _| true).unwrap();
        system.organs.push(organ);
    };
    assert_eq!(new(&with_organ, usual, 25.0), NoFrames::Organs { found: 1 });
    let in_bone = |system: &mut System| {
        let bone = ObstacleContact::new(&system.bodies, 0, surface(below(6.0), 10.0), 0.03, |_, n| n.z < -0.5).unwrap();
        system.obstacles.push(bone);
    };
    let found = new(&in_bone, usual, 25.0);
    // The bottom is held: what the bone is in and could leave are the sides, where no contact with it is prepared.
    assert!(
        matches!(found, NoFrames::Start(Refused::OutOfReach { depth }) if depth > 4.0),
        "{found}"
    );
    assert_eq!(new(&|_| {}, usual, 0.0), NoFrames::NoPoint { body: 0 });
    let free = |system: &mut System| system.fixed.fill(false);
    assert_eq!(new(&free, usual, 25.0), NoFrames::NoFactor);
    for (settings, name) in [
        (
            Settings {
                tolerance: 0.0,
                ..usual
            },
            "tolerance",
        ),
        (
            Settings {
                depth: f64::NAN,
                ..usual
            },
            "depth",
        ),
        (Settings { refresh: -1.0, ..usual }, "refresh"),
        (Settings { depth: 1.1, ..usual }, "depth"),
        (Settings { most_steps: 0, ..usual }, "most_steps"),
        (Settings { most_parts: 0, ..usual }, "most_parts"),
        (
            Settings {
                least_force: Some(0.0),
                ..usual
            },
            "least_force",
        ),
    ] {
        let found = new(&|_| {}, settings, 25.0);
        assert!(
            matches!(found, NoFrames::Setting { name: found, .. } if found == name),
            "{found}"
        );
    }
    let of = |body: usize, size: usize, tube: Tube| {
        let system = block(COARSE, 0.45);
        Frames::new(system, vec![0.0; size], body, tube, usual, top(25.0))
            .map(|_| ())
            .unwrap_err()
    };
    let size = block(COARSE, 0.45).initial().len();
    assert_eq!(of(1, size, tube()), NoFrames::NoBody { body: 1, solids: 1 });
    let found = of(0, 3, tube());
    assert_eq!(
        found,
        NoFrames::Size {
            found: 3,
            expected: size
        }
    );
    let deep = tube().at(pose(6.0, 0.0, 0.0)).unwrap();
    assert!(matches!(of(0, size, deep), NoFrames::TooDeep { most: 5.0, .. }));
    // Wholly inside, where no point of a surface is in it.
    let within = Tube::straight(Point3::new(0.0, 0.0, 50.0), Vector3::z(), 0.0, 10.0).unwrap();
    assert!(matches!(of(0, size, within), NoFrames::TooDeep { most: 2.0, .. }));
    let infinite = || {
        let system = block(COARSE, 0.45);
        let a = vec![f64::NAN; system.initial().len()];
        Frames::new(system, a, 0, tube(), usual, top(25.0))
            .map(|_| ())
            .unwrap_err()
    };
    assert_eq!(infinite(), NoFrames::NoEnergy);
}
