//! A tube that is held still, and one that nothing is near.

use simulation::space::frames::{Settings, State};

use super::{COARSE, FINER, pushed};
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
