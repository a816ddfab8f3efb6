//! From frame to frame: the block pushed by a tube, held against `settle`, which shares neither factors nor contact with it.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use simulation::control::{Newton, Settings as Control};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::frames::{Frames, NoFrames, Refused, Settings, State};
use simulation::space::term::{ObstacleContact, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

use crate::block::{Grid, block, frames, pose, top, tube};
use crate::contact::obstacle::{below, surface};

/// 12.5 mm at the tip: as coarse as the tube's 10 mm lets it be.
const COARSE: Grid = Grid {
    side: 25.0,
    fine: &[30.0],
};
/// 10 mm.
const FINER: Grid = Grid {
    side: 20.0,
    fine: &[30.0],
};

/// The state and the force by Newton's method with new factors throughout, reached in steps of 2 mm.
fn truth(grid: Grid, nu: f64, last: &Isometry3<f64>) -> (Vec<f64>, Vector3<f64>, f64) {
    let mut system = block(grid, nu);
    let contact = TubeContact::new(&system.bodies, 0, tube(), 0.03, top(25.0)).unwrap();
    system.tubes.push(contact);
    let order = Dissection::by_places(&system.places(), &[]).unwrap();
    let control = Control {
        provisional: true,
        ..Control::default()
    };
    let (mut newton, mut a) = (Newton::ordered_by(control, order), system.initial());
    let way = tube().way_to(last);
    let count = (way / 2.0).ceil() as usize;
    let mut energy = 0.0;
    for k in 0..count {
        let next = system.tubes[0].tube().toward(last, 1.0 / (count - k) as f64);
        system.tubes[0].move_to(next);
        energy = settle(&mut system, &mut newton, &mut a, &Tolerance::default())
            .unwrap()
            .energy;
    }
    let force = system.tubes[0].force(&system.bodies, &a).force;
    (a, force, energy)
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// There in frames of 1/3 mm, as at 20 mm/s.
fn pushed(frames: &mut Frames, depths: impl Iterator<Item = u32>) {
    for k in depths {
        let frame = frames.frame(&pose(f64::from(k) / 3.0, 0.0, 0.0));
        assert_eq!(frame.state, State::Settled, "{k}: {frame:?}");
        assert!(frame.least_determinant > 0.5, "{k}: {frame:?}");
    }
}

#[test]
fn frames_end_where_a_search_with_new_factors_ends_and_come_back() {
    let mut frames = frames(FINER, 0.49, 25.0, Settings::default());
    pushed(&mut frames, 1..=36);
    let last = pose(12.0, 0.0, 0.0);
    let (a, force, energy) = truth(FINER, 0.49, &last);
    let found = frames.frame(&last);
    let off = largest(frames.state(), &a);
    println!(
        "{:.5} N, off by {:.1e} N, places by {off:.1e} mm: {found:?}",
        force.z,
        found.force.force.z - force.z
    );
    // A thousandth of the forces may be free; of displacements of 12 mm a thousandth is 0.012.
    assert!((found.force.force.z / force.z - 1.0).abs() < 1e-3);
    assert!(off < 0.012, "{off}");
    assert!((found.energy / energy - 1.0).abs() < 1e-3);
    // What is said of what is left holds it, within the digit that such a statement has.
    pushed(&mut frames, (0..36).rev());
    let back = frames.frame(&pose(0.0, 0.0, 0.0));
    let left = frames.state().iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    println!("back: {left:.1e} mm, {:.1e} N", back.force.force.norm());
    // The least force by which a frame without contact is measured moves so much at most: a thousandth of a thousandth of the block.
    assert!(left < 0.1 && back.force.force.norm() < 1e-3);
}

#[test]
fn a_smaller_tolerance_is_kept_and_brings_states_nearer() {
    let settings = Settings {
        tolerance: 1e-7,
        depth: 1e-6,
        most_steps: 40,
        ..Settings::default()
    };
    let mut frames = frames(COARSE, 0.45, 25.0, settings);
    pushed(&mut frames, 1..=18);
    let last = pose(6.0, 0.0, 0.0);
    let (a, force, _) = truth(COARSE, 0.45, &last);
    let found = frames.frame(&last);
    println!(
        "{:.1e} N, {:.1e} mm",
        found.force.force.z - force.z,
        largest(frames.state(), &a)
    );
    // 1e-7 of the forces, times what a ten times softer mode makes of it; depths of 1e-6 mm.
    assert!((found.force.force.z / force.z - 1.0).abs() < 1e-5);
    assert!(largest(frames.state(), &a) < 1e-4);
}

/// From the middle of the tip to an origin elsewhere.
fn aside() -> Isometry3<f64> {
    Isometry3::translation(-3.0, 2.0, -15.0)
}

#[test]
fn the_stiffness_of_the_tube_is_the_slope_of_its_force() {
    // New factors in each frame: the stiffness is that of the state itself.
    let settings = Settings {
        tolerance: 1e-9,
        depth: 1e-8,
        most_steps: 40,
        refresh: 1e-9,
        delay: 0,
        ..Settings::default()
    };
    // The tube's own origin is beside its axis and below its tip, so that forces have moments about it.
    let axis = [Point3::new(3.0, -2.0, 15.0), Point3::new(3.0, -2.0, 200.0)];
    let odd = Tube::new(pose(0.0, 0.0, 0.0) * aside(), &axis, &[10.0; 2]).unwrap();
    let system = block(COARSE, 0.45);
    let a = system.initial();
    let mut frames = Frames::new(system, a, 0, odd, settings, top(25.0)).unwrap();
    assert_eq!(frames.stiffness().unwrap(), nalgebra::Matrix6::zeros());
    let middle = pose(5.0, 1.0, 0.03) * aside();
    for k in 1..=4 {
        let part = f64::from(k) / 4.0;
        frames.frame(&(pose(5.0 * part, part, 0.03 * part) * aside()));
    }
    // Small enough that no point comes or goes; forces have 1e-9 of 0.3 N, so slopes some 1e-5 N/mm.
    let small = 2e-4;
    let mut slope = nalgebra::Matrix6::zeros();
    let moved = |k: usize, by: f64| {
        let mut pose = middle;
        if k < 3 {
            pose.translation.vector[k] += by;
        } else {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(k - 3, by));
            pose.rotation = turn * pose.rotation;
        }
        pose
    };
    for k in 0..6 {
        let mut sides = [small, -small].map(|by| {
            let found = frames.frame(&moved(k, by));
            assert_eq!(found.state, State::Settled);
            (found.force.force, found.force.moment)
        });
        sides[0].0 -= sides[1].0;
        sides[0].1 -= sides[1].1;
        slope
            .fixed_view_mut::<3, 1>(0, k)
            .copy_from(&(sides[0].0 / (2.0 * small)));
        slope
            .fixed_view_mut::<3, 1>(3, k)
            .copy_from(&(sides[0].1 / (2.0 * small)));
    }
    frames.frame(&middle);
    let found = frames.stiffness().unwrap();
    let off = (found - slope).abs();
    println!("{found:.5}{slope:.5}{off:.2e}");
    // Turns are of radians: their columns and rows are lengths of the tube larger.
    assert!(off.fixed_view::<3, 3>(0, 0).max() < 1e-4 * slope.fixed_view::<3, 3>(0, 0).norm());
    assert!(off.max() < 1e-4 * slope.norm(), "{off}");
}

#[test]
fn what_the_tube_does_is_what_the_tissue_holds_and_its_work_is_the_energy() {
    let settings = Settings {
        tolerance: 1e-9,
        depth: 1e-8,
        most_steps: 40,
        ..Settings::default()
    };
    let mut frames = frames(COARSE, 0.45, 25.0, settings);
    // Aside and tilted, so that turns do work too.
    let at = |k: i32| pose(0.2 * f64::from(k), 0.05 * f64::from(k), 0.004 * f64::from(k));
    let (mut work, mut most) = (0.0, 0.0_f64);
    for k in (1..=25).chain((0..25).rev()) {
        let before = frames.stiffness().unwrap();
        let from = *frames.tube().pose();
        let found = frames.frame(&at(k));
        assert_eq!(found.state, State::Settled, "{k}: {found:?}");
        let after = frames.stiffness().unwrap();
        let turn = from.rotation.rotation_to(&at(k).rotation).scaled_axis();
        let way = at(k).translation.vector - from.translation.vector;
        let motion = nalgebra::Vector6::new(way.x, way.y, way.z, turn.x, turn.y, turn.z);
        // The trapezoid's own error, by the slopes at both ends (Euler and Maclaurin): what is left is of fifth order.
        work += found.work - motion.dot(&((before - after) * motion)) / 12.0;
        most = most.max(found.energy);
        if k == 25 {
            println!("energy {} work {work}", found.energy);
            // Points come and go within steps, each a jump of the slope.
            assert!((work / found.energy - 1.0).abs() < 1e-3);
            let mut inner = vec![0.0; frames.state().len()];
            frames
                .system()
                .bodies
                .solid(0)
                .gradient(frames.state(), &mut inner)
                .unwrap();
            let fixed = inner
                .chunks_exact(3)
                .zip(frames.system().fixed.chunks_exact(3))
                .filter(|(_, fixed)| fixed[0]);
            let ground: Vector3<f64> = fixed.map(|(f, _)| Vector3::new(f[0], f[1], f[2])).sum();
            // A thousand free forces, all together 1e-9 of those of contact.
            assert!(
                (ground - found.force.force).norm() < 1e-7 * ground.norm(),
                "{ground} {:?}",
                found.force
            );
        }
    }
    println!(
        "energy back at the start {:e}, work {work:e} of {most}",
        frames.frame(&at(0)).energy
    );
    // The same ends of each step both ways: what it errs by there it errs by back.
    assert!(work.abs() < 1e-6 * most);
}

#[test]
fn the_same_poses_give_the_same_bits_with_a_second_thread() {
    let run = || {
        let mut frames = frames(COARSE, 0.45, 25.0, Settings::default());
        let found: Vec<_> = (1..=12)
            .map(|k| frames.frame(&pose(f64::from(k) * 0.8, 0.1 * f64::from(k), 0.01 * f64::from(k))))
            .collect();
        (frames.state().to_vec(), found)
    };
    let (one, other) = (run(), run());
    assert!(
        one.1
            .last()
            .is_some_and(|frame| frame.factor > 2 && frame.state == State::Settled)
    );
    assert_eq!(one, other);
}

#[test]
fn a_tube_that_jumps_is_walked_there_and_says_so() {
    let mut frames = frames(
        COARSE,
        0.45,
        25.0,
        Settings {
            most_parts: 1,
            ..Settings::default()
        },
    );
    let last = pose(10.0, 3.0, 0.05);
    let mut before = f64::INFINITY;
    let mut frame = frames.frame(&last);
    while let State::CatchingUp { left } = frame.state {
        assert!(left < before, "{left}");
        before = left;
        frame = frames.frame(&last);
    }
    // One more, as what was walked in steps on the way may need one.
    if frame.state == State::Approximate {
        frame = frames.frame(&last);
    }
    assert_eq!(frame.state, State::Settled, "{frame:?}");
    assert!(before < 20.0);
    let (a, force, _) = truth(COARSE, 0.45, &last);
    assert!((frame.force.force - force).norm() < 2e-3 * force.norm());
    assert!(largest(frames.state(), &a) < 0.02);
}

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
    let new = |change: &dyn Fn(&mut simulation::space::system::System), settings: Settings, reach: f64| {
        let mut system = block(COARSE, 0.45);
        change(&mut system);
        let a = system.initial();
        Frames::new(system, a, 0, tube(), settings, top(reach))
            .map(|_| ())
            .unwrap_err()
    };
    let usual = Settings::default();
    let with_tube = |system: &mut simulation::space::system::System| {
        let contact = TubeContact::new(&system.bodies, 0, tube(), 0.03, top(25.0)).unwrap();
        system.tubes.push(contact);
    };
    assert_eq!(new(&with_tube, usual, 25.0), NoFrames::Tubes { found: 1 });
    let with_term = |system: &mut simulation::space::system::System| {
        let contact = TubeContact::new(&system.bodies, 0, tube(), 0.03, top(25.0)).unwrap();
        system.others.push(Box::new(contact));
    };
    assert_eq!(new(&with_term, usual, 25.0), NoFrames::Changing { term: 0 });
    let with_bone = |system: &mut simulation::space::system::System| {
        let bone = ObstacleContact::new(&system.bodies, 0, surface(below(-5.0), 10.0), 0.03, |_, _| true).unwrap();
        system.obstacles.push(bone);
    };
    assert_eq!(new(&with_bone, usual, 25.0), NoFrames::Contacts { found: 1 });
    assert_eq!(new(&|_| {}, usual, 0.0), NoFrames::NoPoint { body: 0 });
    let free = |system: &mut simulation::space::system::System| system.fixed.fill(false);
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
