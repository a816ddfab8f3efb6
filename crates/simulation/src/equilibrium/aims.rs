//! From which forces times gaps the steps to exact contact come down, and how fast.

use super::step::with;
use crate::constraint::Progress;
use crate::system::System;

/// Each aim, in the one before.
const WORK_FACTOR: f64 = 0.1;
/// This many times the aim in forces out of balance are near enough for the next one: what is free to roll or slide has small forces
/// and long ways, which are to be made while gaps are wide.
pub(super) const NEAR_AIMS: f64 = 1e4;
/// Of the largest force times the depth by which rows are violated, where the way is made carefully and where quickly.
// Figure 40, a wall moves by 1e-3 a frame: 10.5 steps at 1e-1, 8.2 at 1e-3, 7.8 at 1e-4, 6.6 at 1e-6. Gaps of 1e-4 of the way are left for
// rows that come and go.
const CAREFUL_CLOSER: f64 = 0.1;
const QUICK_CLOSER: f64 = 1e-4;
/// An aim that took at most so many steps is followed by a quicker fall.
const QUICK_STEPS: usize = 2;

/// An aim that so many steps have not reached goes up again by this factor, so many times and to so much at most.
// What rolls a long way is held by gaps that are narrow beside the way. Figure 38 in twenty meshes and widths: 178 steps in the mean with this,
// 202 without; after twelve steps instead of eight one of them took 707.
const PATIENT_STEPS: usize = 8;
const WIDER_FACTOR: f64 = 10.0;
const MOST_WIDENED: usize = 3;
const MOST_WIDE: f64 = 1e-2;

/// How the aim falls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Aims {
    /// From wide gaps, tenfold from aim to aim: forces are still to be found.
    Careful,
    /// From a solution that hardly changes: its rows and forces are nearly those that are looked for.
    Quick,
}

/// The aim now, and what has become of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Path {
    aims: Aims,
    /// Force times gap that steps aim at.
    pub(super) work: f64,
    /// Steps made at it.
    steps: usize,
    widened: usize,
}

impl Path {
    fn new(aims: Aims, work: f64) -> Self {
        Self {
            aims,
            work,
            steps: 0,
            widened: 0,
        }
    }

    /// Where it starts: at the work that there is, or more where forces are out of balance or walls have come closer since; `least`
    /// at least.
    pub(super) fn start(aims: Aims, system: &mut System, progress: &Progress, residual: f64, least: f64) -> Self {
        let found = WORK_FACTOR * progress.work / progress.rows.max(1.0);
        let part = match aims {
            Aims::Careful => CAREFUL_CLOSER,
            Aims::Quick => QUICK_CLOSER,
        };
        let closer = part * progress.largest * progress.violation;
        // The last one is the test of balance in `polish`, solved for the work: the aim at which this residual is just near
        // enough.
        let unbalanced = residual * system.bodies.extent() / NEAR_AIMS;
        let work = found.max(closer).max(unbalanced).max(least);
        if aims == Aims::Quick {
            with(system, |rows, _| rows.recentre(work));
        }
        Self::new(aims, work)
    }

    /// The aim is reached: the next one, `least` at least; `unit` is the largest load times the largest solid.
    pub(super) fn fall(&mut self, unit: f64, least: f64) {
        // Newton's method leaves the square of what it began with: near the solution the aim may fall faster than by a factor.
        let fast = self.aims == Aims::Quick && self.steps <= QUICK_STEPS;
        let part = if fast { (self.work / unit).sqrt() } else { WORK_FACTOR };
        self.work = (part.min(WORK_FACTOR) * self.work).max(least);
        self.steps = 0;
    }

    /// One more step at this aim, or where it has taken too many at a wider one. True where it is wider: rows are to be recentred.
    pub(super) fn step(&mut self, unit: f64) -> bool {
        self.steps += 1;
        let wider = (WIDER_FACTOR * self.work).min(MOST_WIDE * unit);
        if self.steps <= PATIENT_STEPS || self.widened >= MOST_WIDENED || wider <= self.work {
            return false;
        }
        (self.work, self.steps, self.widened) = (wider, 1, self.widened + 1);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_aim_falls_tenfold_or_faster_where_a_solution_is_near_and_never_below_the_least() {
        let after = |aims, steps, work| {
            let mut path = Path::new(aims, work);
            (0..steps).for_each(|_| assert!(!path.step(1.0)));
            path.fall(1.0, 1e-10);
            path.work
        };
        let near = |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1e-12, "{found:e} {wanted:e}");
        near(after(Aims::Careful, 1, 1e-6), 1e-7);
        near(after(Aims::Quick, 3, 1e-6), 1e-7);
        near(after(Aims::Quick, 2, 1e-6), 1e-9);
        // Its root is more than a tenth.
        near(after(Aims::Quick, 1, 0.5), 0.05);
        near(after(Aims::Quick, 1, 1e-9), 1e-10);
    }

    #[test]
    fn an_aim_that_is_not_reached_goes_up_three_times_and_not_above_what_is_wide() {
        let mut path = Path::new(Aims::Careful, 1e-6);
        let up: Vec<usize> = (0..100).filter(|_| path.step(1.0)).collect();
        // The ninth step is the first at the next aim.
        assert_eq!(up, [8, 16, 24]);
        assert!((path.work / 1e-3 - 1.0).abs() < 1e-12, "{:e}", path.work);
        let mut wide = Path::new(Aims::Careful, 2e-2);
        assert!((0..100).all(|_| !wide.step(1.0)));
        assert_eq!(wide.work, 2e-2);
    }
}
