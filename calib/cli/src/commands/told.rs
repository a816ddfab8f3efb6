//! A motion as it is told while it goes on.

use bus::message::{StepMotion, StepMotionKind};
use calib::coverage::seen::{RINGS, SECTORS, Seen, TURN_CELLS};

const _: () = assert!(SECTORS == StepMotion::SECTORS && RINGS == StepMotion::RINGS);
const _: () = assert!(TURN_CELLS == StepMotion::TURN_CELLS);

pub(super) fn told(kind: StepMotionKind, seen: &Seen) -> StepMotion {
    StepMotion {
        reach_rad: seen.reach_rad,
        reached_rad: seen.reached_rad,
        needed_rad: seen.needed_rad,
        now_rad: seen.now_rad,
        cells: [seen.cells as u64, (seen.cells >> 64) as u64],
        kind: kind.code(),
        up: seen.up as u32,
    }
}
