//! The iteration.

use crate::{Damping, End, Made, Outcome, Problem};

/// What an iteration may take.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Steps that are made.
    pub steps: usize,
    /// Steps that are tried, made or not.
    pub tries: usize,
    /// Growth of the cost that is rounding, as a factor: a step that lets it grow by that is made.
    pub flat: f64,
}

impl Limits {
    /// So many steps, made or not; growth by 1e-12 is rounding.
    pub const fn tries(tries: usize) -> Self {
        Self {
            steps: tries,
            tries,
            // A sum of n squares is rounded by up to n / 2 ulp of itself: this holds for some thousand terms.
            flat: 1.0 + 1e-12,
        }
    }

    /// So many steps made, after as many tries as the greatest damping allows; growth by 1e-12 is rounding.
    pub const fn steps(steps: usize) -> Self {
        Self {
            steps,
            tries: usize::MAX,
            flat: 1.0 + 1e-12,
        }
    }
}

/// The least of a sum of squares near `start`: steps of Gauss and Newton, held back where they lead up (Levenberg 1944,
/// Marquardt 1963).
///
/// A cost that is not a number is never gone to. `None` where `start` is impossible.
pub fn least_squares<P: Problem>(
    problem: &P,
    start: P::State,
    damping: Damping,
    limits: Limits,
) -> Option<Outcome<P::State, P::At>> {
    let (cost, at) = problem.look(&start)?;
    let mut held = damping.held();
    let mut now = Outcome {
        state: start,
        at,
        before: None,
        cost,
        end: End::OutOfSteps,
        steps: 0,
        length: f64::INFINITY,
        gain: f64::INFINITY,
    };
    // Counted apart from the steps: raising the damping makes no step, and must end too.
    let mut tries = 0;
    let mut is_prepared = false;
    while tries < limits.tries && now.steps < limits.steps {
        // Once for each state: a step that is tried again with more damping has the same equations.
        if !is_prepared && !problem.prepare(&now.state, &mut now.at, now.steps) {
            return Some(ended(now, End::Singular));
        }
        (tries, is_prepared) = (tries + 1, true);
        let step = problem.step(&now.state, &now.at, held.value);
        if step.is_none() && !damping.singular {
            return Some(ended(now, End::Singular));
        }
        if let Some(step) = step {
            let (length, gain) = (step.length, step.gain);
            // Before the look: so near the end the cost is flat to rounding, and a comparison would be of noise.
            if problem.is_last(&step, &now.at, held.value) {
                (now.state, now.length, now.gain) = (step.to, length, gain);
                now.steps += 1;
                return Some(ended(now, End::Last));
            }
            // A NaN is no fall.
            let lower = problem
                .look(&step.to)
                .filter(|(cost, _)| *cost <= now.cost * limits.flat);
            if let Some((cost, at)) = lower {
                let (from, by) = (now.cost, held.value);
                // At the end both are zero, or rounding of either sign; without the bound 0 / 0 would make the damping
                // NaN.
                held.lower((from - cost) / gain.max(f64::MIN_POSITIVE));
                now = Outcome {
                    state: step.to,
                    at,
                    before: Some(now.at),
                    cost,
                    end: End::OutOfSteps,
                    steps: now.steps + 1,
                    length,
                    gain,
                };
                let made = Made {
                    state: &now.state,
                    at: &now.at,
                    length,
                    from,
                    to: cost,
                    damping: by,
                };
                if problem.is_settled(&made) {
                    return Some(ended(now, End::Settled));
                }
                is_prepared = false;
                continue;
            }
            if problem.is_flat(&step, held.value) {
                return Some(ended(now, End::Flat));
            }
        }
        // After an uphill step and after singular equations alike: more damping shortens the one and regularises the
        // other.
        held.raise();
        if held.value > damping.most {
            return Some(ended(now, End::Nowhere));
        }
    }
    Some(now)
}

fn ended<S, A>(now: Outcome<S, A>, end: End) -> Outcome<S, A> {
    Outcome { end, ..now }
}
