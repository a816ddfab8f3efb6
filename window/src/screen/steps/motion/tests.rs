//! What is drawn and said of a motion, by its own numbers.

use super::*;

fn motion(kind: StepMotionKind, reach_rad: [f64; StepMotion::SECTORS], needed_rad: f64) -> StepMotion {
    StepMotion {
        kind: kind.code(),
        reach_rad,
        needed_rad,
        reached_rad: reach_rad.iter().copied().fold(f64::INFINITY, f64::min),
        ..StepMotion::NONE
    }
}

/// Just below what is needed, and what is no number: neither the ring nor a word says that it is enough.
#[test]
fn a_ring_is_full_of_a_motion_that_is_enough_and_of_no_other() {
    let needed = 20_f64.to_radians();
    for (reach, is_enough) in [
        (needed, true),
        (needed * (1.0 - 1e-12), false),
        (0.9 * needed, false),
        (0.0, false),
        (-1.0, false),
        (f64::NAN, false),
    ] {
        for (at, kind) in [
            (3, StepMotionKind::Pivot),
            (23, StepMotionKind::Pivot),
            (0, StepMotionKind::Spin),
        ] {
            let mut reaches = [1.5 * needed; StepMotion::SECTORS];
            reaches[at] = reach;
            if kind == StepMotionKind::Spin {
                reaches = [reach; StepMotion::SECTORS];
            }
            let motion = motion(kind, reaches, needed);
            let is_full = match kind {
                StepMotionKind::Pivot => (0..StepMotion::SECTORS).all(|k| filled(&motion, k) == 1.0),
                StepMotionKind::Spin => (0..SIDE_CELLS).all(|k| is_turned(&motion, k)),
            };
            assert_eq!(
                (is_full, motion.is_complete()),
                (is_enough, is_enough),
                "{kind:?} {reach}"
            );
            let words = said(&motion, kind).join("\n");
            assert_eq!(words.contains("ENOUGH"), is_enough, "{words}");
            assert_eq!(
                words.contains("20.0 of 20.0 degrees"),
                is_enough && reach.is_finite(),
                "{words}"
            );
        }
    }
}

#[test]
fn what_is_not_reached_leaves_its_cell_open() {
    let needed = 0.4;
    for share in [0.0, 0.1, 0.5, 0.999_999] {
        let motion = motion(StepMotionKind::Pivot, [share * needed; StepMotion::SECTORS], needed);
        assert!(filled(&motion, 0) <= MOST_UNREACHED, "{share}");
    }
}
