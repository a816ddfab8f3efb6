//! The last steps to exact contact: Newton's method on the balance of forces, gaps, and forces times gaps together.

use super::aims::{Aims, NEAR_AIMS, Path};
use super::refine::refine;
use super::step::{advance, balance, review, with};
use crate::control::Newton;
use crate::system::System;

/// The most steps.
const MOST_STEPS: usize = 250;
/// Forces times gaps at the end, in largest loads times largest solids.
const LAST_WORK: f64 = 1e-10;
/// Forces off by this part of the largest load are near enough for the next aim.
const NEAR_LOADS: f64 = 0.1;
/// Depths below this part of the largest solid are none.
const NO_DEPTH: f64 = 1e-13;

/// What the polish found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polished {
    pub(super) done: bool,
    pub(super) steps: usize,
    /// The largest free force and the largest load at the end.
    pub(super) balance: [f64; 2],
}

/// Moves `a` and the forces of all exact contacts to where forces balance, gaps are positive, and none has both.
///
/// Where a contact has next to no force, gaps fall with the square root of the work only: then it goes on to less work as
/// long as that converges.
pub(super) fn polish(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>, aims: Aims) -> Polished {
    let extent = system.bodies.extent();
    let mut progress = review(system, a, false);
    let (mut path, mut last_balance) = (None, [f64::INFINITY; 2]);
    for steps in 0..MOST_STEPS {
        let ended = |done, balance| Polished { done, steps, balance };
        let Some([residual, load]) = balance(system, a) else {
            return ended(false, last_balance);
        };
        last_balance = [residual, load];
        let last = LAST_WORK * load * extent;
        let path = path.get_or_insert_with(|| Path::start(aims, system, &progress, residual, last));
        let work = path.work;
        let [part, room] = near(work, last, [load, extent], newton.settings.tolerance);
        let aimed = progress.complementarity <= 10.0 * work && progress.violation <= room;
        // More than rounding leaves of forces is asked for nowhere; what that is takes a matrix to know, so it comes last.
        let balanced = || residual <= part * load || Newton::is_within_potential_rounding(system, a, part * load);
        if aimed && balanced() {
            progress = review(system, a, true);
            if progress.violation <= room {
                if work <= last {
                    let more = if progress.undecided {
                        refine(system, newton, a, work, load)
                    } else {
                        0
                    };
                    return Polished {
                        steps: steps + more,
                        ..ended(true, last_balance)
                    };
                }
                path.fall(load * extent, last);
            }
        }
        if path.step(load * extent) {
            with(system, |rows, _| rows.recentre(path.work));
        }
        if !advance(system, newton, a, path.work) {
            return ended(false, last_balance);
        }
        progress = review(system, a, false);
    }
    Polished {
        done: false,
        steps: MOST_STEPS,
        balance: last_balance,
    }
}

/// How near is near enough to an aim for the next, or at the last one, to stay: free forces in loads, and the depth of rows.
fn near(work: f64, last: f64, [load, extent]: [f64; 2], tolerance: f64) -> [f64; 2] {
    let [part, depth] = if work > last {
        let part = NEAR_AIMS * work / (load * extent);
        [part.clamp(tolerance, NEAR_LOADS), NEAR_LOADS]
    } else {
        [tolerance; 2]
    };
    // A row with a force of one load has the gap `work / load` at this aim.
    [part, (depth * work / load).max(NO_DEPTH * extent)]
}
