//! Tissue at rest where no tube touches it.

use simulation::space::frames::{Settings, State};

use super::COARSE;
use crate::block::{frames, pose};

#[test]
fn tissue_that_is_left_lies_as_before_to_the_bit_and_only_where_the_tube_touches_none_of_it() {
    let mut all = frames(COARSE, 0.3, 40.0, Settings::default());
    let (start, factor) = (all.state().to_vec(), 1);
    assert!(all.is_free());
    // 20 mm above the block, far beyond a walk of some radii.
    let above = all.rest(&pose(-20.0, 5.0, 0.1)).unwrap();
    assert_eq!(
        (above.state, above.energy, above.force.points),
        (State::Settled, 0.0, 0)
    );
    assert_eq!((above.factor, all.tube().pose()), (factor, &pose(-20.0, 5.0, 0.1)));
    for depth in [-1.0, 1.0, 3.0] {
        while all.frame(&pose(depth, 5.0, 0.0)).state != State::Settled {}
    }
    assert!(!all.is_free() && all.state() != start.as_slice());
    // In the block, and in it whole: there is no rest.
    let before = all.state().to_vec();
    for inside in [pose(3.0, 5.0, 0.0), pose(0.5, 0.0, 0.0), pose(45.0, 0.0, 0.0)] {
        assert!(!all.is_clear(&inside) && all.rest(&inside).is_none());
        assert_eq!(
            (all.state(), all.tube().pose()),
            (before.as_slice(), &pose(3.0, 5.0, 0.0))
        );
    }
    let left = all.rest(&pose(-0.5, 0.0, 0.0)).unwrap();
    assert_eq!((all.state(), left.energy, left.residual), (start.as_slice(), 0.0, 0.0));
    // And on from there as from the start.
    let again = all.frame(&pose(1.0, 0.0, 0.0));
    assert!(again.force.force.z > 0.0 && again.energy > 0.0, "{again:?}");
}
