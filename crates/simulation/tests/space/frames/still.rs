//! A tube that is held still, and one that nothing is near.

use simulation::space::frames::{Settings, State};

use super::{COARSE, FINER, largest, pushed};
use crate::block::{frames, pose};

#[test]
fn a_tube_that_is_held_still_stays_settled_without_a_step() {
    let mut frames = frames(FINER, 0.49, 25.0, Settings::default());
    pushed(&mut frames, 1..=30);
    let (before, force) = (frames.state().to_vec(), frames.force());
    for k in 0..20 {
        let found = frames.frame(&pose(10.0, 0.0, 0.0));
        assert_eq!((found.state, found.steps), (State::Settled, 0), "{k}: {found:?}");
        assert!(found.residual > 0.0 && found.residual <= 1e-3);
    }
    assert_eq!((frames.state(), frames.force()), (before.as_slice(), force));
}

#[test]
fn a_hand_that_trembles_is_followed_however_little() {
    for by in [2e-2, 1e-3, 1e-4, 1e-6] {
        let mut frames = frames(COARSE, 0.49, 25.0, Settings::default());
        pushed(&mut frames, 1..=24);
        for k in 0..12 {
            // Not the same way to and fro.
            let (up, aside) = (f64::from(k * 5 % 7) - 3.0, f64::from(k * 3 % 5) - 2.0);
            let found = frames.frame(&pose(8.0 + by * up, by * aside, 0.0));
            assert_eq!(found.state, State::Settled, "{by} {k}: {found:?}");
        }
    }
}

#[test]
fn a_fast_tube_in_free_air_makes_no_factors() {
    let mut frames = frames(COARSE, 0.45, 25.0, Settings::default());
    while frames.frame(&pose(-20.0, 0.0, 0.0)).state != State::Settled {}
    // What was asked for on the way is taken up.
    let taken_up = (0..5).map(|_| frames.frame(&pose(-20.0, 0.0, 0.0)).factor);
    let factor = taken_up.last().unwrap();
    for k in 1..=10 {
        // 12 mm a frame: three parts of a way, all of them free.
        let found = frames.frame(&pose(-20.0 - 12.0 * f64::from(k), 0.0, 0.0));
        assert_eq!(
            (found.state, found.factor, found.steps),
            (State::Settled, factor, 0),
            "{found:?}"
        );
    }
}

#[test]
fn what_is_left_unsettled_is_not_told_too_small() {
    let strict = Settings {
        tolerance: 1e-8,
        depth: 1e-6,
        most_steps: 60,
        ..Settings::default()
    };
    let [mut usual, mut exact] = [Settings::default(), strict].map(|settings| frames(COARSE, 0.49, 25.0, settings));
    let mut most = 0.0_f64;
    for k in (1..=36).chain((18..36).rev()) {
        let depth = pose(f64::from(k) / 3.0, 0.0, 0.0);
        let [found, truth] = [usual.frame(&depth), exact.frame(&depth)];
        assert_eq!([found.state, truth.state], [State::Settled; 2], "{k}");
        let off = largest(usual.state(), exact.state());
        assert!(off <= found.unsettled, "{k}: {off} of {}", found.unsettled);
        most = most.max(found.unsettled);
    }
    println!("at most {most:.1e} mm");
    // A bound that says nothing would be one too.
    assert!(most < 0.2);
}
