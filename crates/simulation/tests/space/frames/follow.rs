//! Frames end where `settle` ends, come back, are walked where they jump, and are the same in every run.

use simulation::space::frames::{Settings, State};

use super::{COARSE, FINER, largest, pushed, truth};
use crate::block::{frames, pose};

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
fn poses_in_their_order_give_the_same_bits_whenever_the_second_thread_is_done() {
    // In, aside, out, at once farther than a part of a way is long, and held; with rest where the tube is free.
    let poses: Vec<_> = (1..=40)
        .map(|k| {
            let t = f64::from(k);
            let depth = if k % 13 == 0 { -4.0 } else { 6.0 * (0.3 * t).sin() };
            pose(depth, 2.0 * (0.7 * t).cos(), 0.01 * (t % 3.0))
        })
        .collect();
    let run = |pause: &dyn Fn(usize) -> u64| {
        let mut frames = frames(COARSE, 0.45, 25.0, Settings::default());
        let each = poses.iter().enumerate().map(|(k, pose)| {
            // A factor that was asked for is done long before it is due, or not yet begun.
            std::thread::sleep(std::time::Duration::from_millis(pause(k)));
            let resting = if frames.is_free() { frames.rest(pose) } else { None };
            let found = resting.unwrap_or_else(|| frames.frame(pose));
            let bits: Vec<u64> = frames.state().iter().map(|u| u.to_bits()).collect();
            (found, bits)
        });
        each.collect::<Vec<_>>()
    };
    let (lockstep, slow, uneven) = (run(&|_| 0), run(&|_| 30), run(&|k| [0, 60, 3][k * 7 % 3]));
    // New factors were taken up, and where that was is part of what must agree.
    assert!(lockstep.last().is_some_and(|(found, _)| found.factor > 4));
    for (k, one) in lockstep.iter().enumerate() {
        assert!(*one == slow[k] && *one == uneven[k], "{k}: {:?} {:?}", one.0, slow[k].0);
    }
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
