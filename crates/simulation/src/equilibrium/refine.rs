//! From a solution to one with less force times gap: gaps of rows that have next to no force are about the square root of it.

use super::step::{advance, balance, review, with};
use crate::constraint::Constraint;
use crate::control::Newton;
use crate::system::System;

/// The most steps.
const MOST_REFINED: usize = 20;
/// Each work in the one before; where one step has sufficed, the next falls by the square of that.
const REFINED_FALL: f64 = 0.01;
/// The least work, in largest loads times largest solids.
const LEAST_WORK: f64 = 1e-21;
/// Steps to one work before it is given up.
const MOST_AT_ONE: usize = 4;

/// A solution to come back to, and its work.
struct Good {
    a: Vec<f64>,
    terms: Vec<Box<dyn Constraint>>,
    work: f64,
}

impl Good {
    fn new(system: &System, a: &[f64], work: f64) -> Self {
        Self {
            a: a.to_vec(),
            terms: copies(&system.terms),
            work,
        }
    }
}

fn copies(terms: &[Box<dyn Constraint>]) -> Vec<Box<dyn Constraint>> {
    terms.iter().map(|t| t.copy()).collect()
}

/// Steps to less and less work from a solution with the work `work`; the last one that is a solution too is kept. How many.
pub(super) fn refine(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>, work: f64, load: f64) -> usize {
    let least = LEAST_WORK * load * system.bodies.extent();
    let (mut good, mut steps, mut since, mut fall) = (Good::new(system, a, work), 0, 0, REFINED_FALL);
    while steps < MOST_REFINED && good.work > least {
        let aim = (fall * good.work).max(least);
        let moved = advance(system, newton, a, aim);
        (steps, since) = (steps + usize::from(moved), since + 1);
        if moved && solved(system, newton, a, aim) {
            fall = if since == 1 { fall * fall } else { REFINED_FALL };
            (good, since) = (Good::new(system, a, aim), 0);
        } else if !moved || since == MOST_AT_ONE {
            if fall >= REFINED_FALL {
                break;
            }
            // It fell too fast: the same way again in smaller parts.
            a.clone_from(&good.a);
            system.terms = copies(&good.terms);
            (since, fall) = (0, REFINED_FALL);
        }
    }
    (*a, system.terms) = (good.a, good.terms);
    with(system, |t, _| t.aim(None));
    steps
}

/// True where a step has led to a solution with that work.
fn solved(system: &mut System, newton: &Newton, a: &[f64], aim: f64) -> bool {
    let progress = review(system, a, true);
    let near = progress.complementarity <= 10.0 * aim && progress.violation <= 0.0;
    let tolerance = newton.settings.tolerance;
    near && balance(system, a).is_some_and(|[residual, load]| residual <= tolerance * load)
}
