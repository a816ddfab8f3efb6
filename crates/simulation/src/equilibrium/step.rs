//! One step of exact contact: Newton's method on the balance of forces, gaps, and forces times gaps together, and what all rows say of a state.

use crate::constraint::{Active, Constraint, Progress};
use crate::control::{Newton, Potential};
use crate::system::System;

/// Of the way to the first touch.
const BEFORE_TOUCH: f64 = 0.9;
/// Halvings of a step that does not lower the merit.
const MOST_HALVINGS: usize = 6;
/// What a row lacks of its gap counts this many times the largest force.
// An l1 penalty is exact where it exceeds the largest multiplier (Nocedal and Wright 2006, 17.2); twice leaves room.
const PENALTY_FORCES: f64 = 2.0;
/// A merit that rises by this part of the energy does not rise.
const MERIT_ROUNDING: f64 = 1e-12;
/// What rows lack of their gaps must fall to this part, where the merit does not fall.
const CLOSER_FACTOR: f64 = 0.9;

/// Calls each set of rows with the solids.
pub(super) fn with(system: &mut System, mut call: impl FnMut(&mut dyn Active, &System)) {
    // Taken out for the call: rows change while they read the system.
    let mut terms: Vec<Box<dyn Constraint>> = std::mem::take(&mut system.terms);
    terms.iter_mut().filter_map(|t| t.rows()).for_each(|t| call(t, system));
    system.terms = terms;
}

/// Looks at all rows in a new state; where `between`, for arcs that have come together between them too.
pub(super) fn review(system: &mut System, a: &[f64], between: bool) -> Progress {
    let mut progress = Progress::default();
    with(system, |t, system| {
        progress = progress.and(t.review(&system.bodies, a, between))
    });
    progress
}

/// The largest free force of the forces as they are, and the largest load.
pub(super) fn balance(system: &mut System, a: &[f64]) -> Option<[f64; 2]> {
    with(system, |t, _| t.aim(None));
    Newton::balance(system, a)
}

/// One step at an aim. False, and nothing changed, where there is none.
pub(super) fn advance(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>, aim: f64) -> bool {
    with(system, |t, _| t.aim(Some(aim)));
    let Some((next, parts)) = step(system, newton, a) else {
        return false;
    };
    with(system, |t, _| t.take(parts));
    *a = next;
    true
}

/// A Newton step, shortened for gaps, for what it may pass, and for forces.
fn step(system: &mut System, newton: &mut Newton, a: &[f64]) -> Option<(Vec<f64>, [f64; 2])> {
    let (mut step, _) = newton.direction(system, a)?;
    let mut parts = [1.0_f64; 2];
    with(system, |t, system| {
        let own = t.limits(&system.bodies, a, &step);
        parts = [parts[0].min(own[0]), parts[1].min(own[1])];
    });
    // Slacks are shortened first: what follows looks at the step that is left.
    step.iter_mut().for_each(|s| *s *= parts[0]);
    // Before the first look at the next state: rows remember what they find in one state only.
    let before = merit(system, a, 0.0);
    let (part, next) = shortened(system, a, &step)?;
    // Where no part lowers the merit, as near the end where only rounding is left of it, the whole step is tried.
    let (part, next) = before
        .and_then(|before| descend(system, a, &step, [part, parts[0]], before))
        .unwrap_or((part, next));
    parts[0] *= part;
    Some((next, parts))
}

/// Energy, `- w sum ln s`, `sum |g - s|` and the largest force of all rows.
fn merit(system: &mut System, a: &[f64], part: f64) -> Option<[f64; 3]> {
    let mut sum = Some([system.energy(a)?, 0.0, 0.0_f64]);
    with(system, |t, system| {
        sum = sum
            .zip(t.merit(&system.bodies, a, part))
            .map(|(s, m)| [s[0] + m[0], s[1] + m[1], s[2].max(m[2])]);
    });
    sum
}

/// The first of the halved parts that lowers the merit, or what rows lack of their gaps.
fn descend(
    system: &mut System,
    a: &[f64],
    step: &[f64],
    [most, of]: [f64; 2],
    before: [f64; 3],
) -> Option<(f64, Vec<f64>)> {
    let penalty = PENALTY_FORCES * before[2];
    let value = |m: [f64; 3]| m[0] + penalty * m[1];
    let mut part = most;
    for _ in 0..MOST_HALVINGS {
        let next: Vec<f64> = a.iter().zip(step).map(|(a, s)| a + part * s).collect();
        if let Some(after) = merit(system, &next, part * of)
            && (value(after) <= value(before) + MERIT_ROUNDING * before[0].abs()
                || after[1] <= CLOSER_FACTOR * before[1])
        {
            return Some((part, next));
        }
        part *= 0.5;
    }
    None
}

/// The part of a step that passes through nothing and keeps an energy.
fn shortened(system: &System, a: &[f64], step: &[f64]) -> Option<(f64, Vec<f64>)> {
    let reach = system.reach(a, step);
    let mut part = if reach < 1.0 { BEFORE_TOUCH * reach } else { 1.0 };
    // What may be passed says nothing of elements turned inside out, for which the law has no energy.
    for _ in 0..10 {
        let next: Vec<f64> = a.iter().zip(step).map(|(a, s)| a + part * s).collect();
        if system.energy(&next).is_some() {
            return Some((part, next));
        }
        part *= 0.5;
    }
    None
}
