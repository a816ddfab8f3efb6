//! Tissue between the tube and bone: a layer over a ball of bone, held by springs at its sides only, beside `settle` with the same contact.

use nalgebra::{Isometry3, Point3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Settings as Cells};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::frames::{Frame, Frames, Settings, State};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{ContactForce, ObstacleContact, Springs, TubeContact};
use simulation::space::tube::Tube;

use super::largest;
use crate::contact::obstacle::{below, newton, surface};

/// Half the layer's width, its height, the tube's radius, mm, and Young's modulus, N/mm^2.
const HALF: f64 = 30.0;
const HEIGHT: f64 = 20.0;
const RADIUS: f64 = 12.0;
const YOUNG: f64 = 5e-3;

/// A layer whose sides are held softly, a millimetre over a ball of bone.
fn layer() -> System {
    layer_on(|_, n| n.z < -0.5, 0.0, 5e-5)
}

/// The same with contact with the bone at these points only, of this weight by volume, held so softly.
pub(super) fn layer_on(touches: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool, weight: f64, spring: f64) -> System {
    let corners = [Vector3::new(-HALF, -HALF, 0.0), Vector3::new(HALF, HALF, HEIGHT)];
    let mesh = Mesh::new(&below(1e3), corners, &Cells::of_side(10.0), &|_, _| false).unwrap();
    let material = Material::new(Law::NeoHookean, YOUNG, 0.45).unwrap();
    let mut system = System::new();
    system.add(Deformable::new(mesh, material, Vector3::new(0.0, 0.0, -weight)).unwrap());
    let side = move |_: &Vector3<f64>, n: &Vector3<f64>| if n.z.abs() < 0.5 { spring } else { 0.0 };
    let springs = Springs::new(&system.bodies, 0, side, |x| *x);
    system.others.push(Box::new(springs));
    let ball = Ball {
        centre: Vector3::new(0.0, 0.0, -41.0),
        radius: 40.0,
    };
    let contact = ObstacleContact::new(&system.bodies, 0, surface(ball, 15.0), 0.01, touches);
    system.obstacles.push(contact.unwrap());
    system
}

/// The tube, a little aside, with its tip so deep below the top of the layer where that was at first.
pub(super) fn pose(depth: f64) -> Isometry3<f64> {
    Isometry3::translation(3.0, -2.0, HEIGHT - depth + RADIUS)
}

pub(super) fn tube() -> Tube {
    let tube = Tube::straight(Point3::origin(), Vector3::z(), 200.0, RADIUS).unwrap();
    tube.at(pose(0.0)).unwrap()
}

pub(super) fn on_top(_: &Vector3<f64>, n: &Vector3<f64>) -> bool {
    n.z > 0.5
}

fn frames(settings: Settings) -> Frames {
    let system = layer();
    let a = system.initial();
    Frames::new(system, a, 0, tube(), settings, on_top).unwrap()
}

/// The state and the forces on tube and bone by `settle`, in steps of half a millimetre.
fn truth(depth: f64) -> (System, Vec<f64>, [ContactForce; 2]) {
    let mut system = layer();
    let contact = TubeContact::new(&system.bodies, 0, tube(), 0.02, on_top).unwrap();
    system.tubes.push(contact);
    let (mut newton, mut a) = (newton(&system, 1e-9), system.initial());
    let steps = (2.0 * depth).ceil() as usize;
    for k in 1..=steps {
        let next = tube().at(pose(depth * k as f64 / steps as f64)).unwrap();
        system.tubes[0].move_to(next);
        settle(&mut system, &mut newton, &mut a, &Tolerance::default()).unwrap();
    }
    let tube = system.tubes[0].force(&system.bodies, &a);
    let bone = system.obstacles[0].force(&system.bodies, &a);
    (system, a, [tube, bone])
}

fn strict() -> Settings {
    Settings {
        tolerance: 1e-7,
        depth: 1e-6,
        most_steps: 40,
        ..Settings::default()
    }
}

fn pushed(frames: &mut Frames, depths: impl Iterator<Item = u32>) -> Option<Frame> {
    let each = depths.map(|k| {
        let found = frames.frame(&pose(f64::from(k) / 4.0));
        assert_eq!(found.state, State::Settled, "{k}: {found:?}");
        found
    });
    each.last()
}

#[test]
fn tissue_between_tube_and_bone_ends_where_a_search_with_new_factors_ends_and_comes_back() {
    let mut frames = frames(strict());
    let found = pushed(&mut frames, 1..=32).unwrap();
    let (_, a, [tube, bone]) = truth(8.0);
    let (on_bone, off) = (frames.bone_force(0).unwrap(), largest(frames.state(), &a));
    println!(
        "tube {:.6}, bone {:.6}, off by {:.1e} and {:.1e} N, {off:.1e} mm, det F {:.2}",
        tube.force,
        bone.force,
        (found.force.force - tube.force).norm(),
        (on_bone.force - bone.force).norm(),
        found.least_determinant
    );
    // Most of what the tube presses goes into the bone, and both take part: nothing here would be seen without it.
    assert!(-bone.force.z > 0.5 * tube.force.z && bone.points > 4);
    // 1e-7 of the forces, times what a ten times softer mode makes of it; `settle` leaves 1e-6 of them, and depths of 6e-5 mm.
    let bound = 1e-4 * tube.force.norm();
    assert!((found.force.force - tube.force).norm() < bound && (on_bone.force - bone.force).norm() < bound);
    assert!(
        (on_bone.moment - bone.moment).norm() < HALF * bound && off < 1e-3,
        "{off}"
    );
    assert_eq!(frames.bone_force(1), None);
    // Off the bone again, where the springs hold it.
    let back = pushed(&mut frames, (0..32).rev()).unwrap();
    let left = frames.state().iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    println!("back: {left:.1e} mm");
    // Off all contact a step is that of a linear problem: what is left is far below a thousandth of the least force on springs of 0.24 N/mm in all.
    assert!(left < 1e-6 && back.force.points == 0 && frames.bone_force(0).unwrap().points == 0);
}

#[test]
fn a_start_that_rests_on_bone_goes_on_from_its_pressures_with_the_same_bits_in_every_run() {
    let run = || {
        let (mut system, a, [tube_force, bone]) = truth(6.0);
        let tube = system.tubes.remove(0).tube().clone();
        let mut frames = Frames::new(system, a.clone(), 0, tube, Settings::default(), on_top).unwrap();
        // Before any frame: the pressures of the state that was settled. Places are summed in another order: some roundings of 60 mm over 15 mm of radius.
        assert!((frames.bone_force(0).unwrap().force - bone.force).norm() < 1e-13 * bone.force.norm());
        let found = frames.frame(&pose(6.0));
        assert_eq!(found.state, State::Settled, "{found:?}");
        assert!((found.force.force - tube_force.force).norm() < 2e-3 * tube_force.force.norm());
        assert!(largest(frames.state(), &a) < 0.02);
        let all: Vec<Frame> = (1..=6).map(|k| frames.frame(&pose(6.0 + 0.4 * f64::from(k)))).collect();
        assert!(all.iter().all(|frame| frame.state == State::Settled), "{all:?}");
        (frames.state().to_vec(), all)
    };
    assert_eq!(run(), run());
}

#[test]
fn the_slope_of_the_force_has_the_bone_behind_the_tissue_in_it() {
    let settings = Settings {
        tolerance: 1e-9,
        depth: 1e-8,
        refresh: 1e-9,
        delay: 0,
        ..strict()
    };
    let mut frames = frames(settings);
    for k in 1..=24 {
        frames.frame(&pose(0.25 * f64::from(k)));
    }
    let small = 2e-4;
    let sides = [small, -small].map(|by| {
        let found = frames.frame(&pose(6.0 + by));
        assert_eq!(found.state, State::Settled, "{found:?}");
        found.force.force
    });
    // Down is against the axis.
    let slope = (sides[0] - sides[1]) / (-2.0 * small);
    frames.frame(&pose(6.0));
    let found = frames.yielding().unwrap().stiffness().unwrap();
    let off = (found.fixed_view::<3, 1>(0, 2) - slope).norm();
    println!("{found:.5}{slope:.5}{off:.1e}");
    // Forces have 1e-9 of some 0.1 N, so slopes 1e-6 N/mm; second derivatives of the force by the way add less.
    assert!(off < 1e-3 * slope.norm(), "{off}");
}
