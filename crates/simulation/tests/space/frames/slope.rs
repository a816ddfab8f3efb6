//! The force on the tube: its slope by differences, its work by the energy.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use simulation::space::frames::{Frames, Settings, State};
use simulation::space::tube::Tube;

use super::COARSE;
use crate::block::{block, frames, pose, top};

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
    assert_eq!(
        frames.yielding().unwrap().stiffness().unwrap(),
        nalgebra::Matrix6::zeros()
    );
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
    let found = frames.yielding().unwrap().stiffness().unwrap();
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
        let before = frames.yielding().unwrap().stiffness().unwrap();
        let from = *frames.tube().pose();
        let found = frames.frame(&at(k));
        assert_eq!(found.state, State::Settled, "{k}: {found:?}");
        let after = frames.yielding().unwrap().stiffness().unwrap();
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
