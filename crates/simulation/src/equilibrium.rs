//! Equilibrium under constraints: searches, with the terms of the constraints brought up to date between them.

mod aims;
mod certify;
mod follow;
mod polish;
mod refine;
mod saddle;
mod step;

use crate::constraint::{Change, Constraint, Stage};
use crate::control::{Failed, Minimum, Newton, Settings};
use crate::system::System;

/// The most searches of one equilibrium.
const MOST_SEARCHES: usize = 60;
/// The largest free force over the largest load in a search whose term is to be replaced.
const PROVISIONAL_TOLERANCE: f64 = 1e-6;
/// Saddles left in exact contact.
const MOST_SADDLES: usize = 4;
/// Tries of the exact equations.
const MOST_POLISHES: usize = 4;
/// Violations below this part of the largest solid count as none.
const NO_VIOLATION: f64 = 1e-9;

/// A state in equilibrium, certified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium {
    /// The last search.
    pub minimum: Minimum,
    /// The last change of a constraint's force.
    pub force_change: f64,
    /// The largest violation of a constraint, a length.
    pub violation: f64,
    /// Searches made.
    pub searches: usize,
    /// Steps of all of them.
    pub iterations: usize,
    /// Contacts are exact: none stands off by a barrier's width.
    pub exact: bool,
    /// The largest force times gap of a contact or link, beside the largest load, or that force itself where it is more, times the
    /// largest solid.
    pub complementarity: f64,
    /// The least gap of a contact: above zero where contacts are exact.
    pub least_gap: f64,
    /// The largest sum of weight, loads and contact forces on a free solid, in largest loads.
    pub imbalance: f64,
    /// Parts that the load was applied in: 1 unless [`settle_in_steps`] had to halve it.
    pub load_steps: usize,
    /// What it took, seconds of the clock.
    pub seconds: f64,
}

/// Why there is no equilibrium to return.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoEquilibrium {
    /// A search failed.
    #[error("search {search}: {cause}")]
    Search {
        /// Which, from 1.
        search: usize,
        /// Why.
        cause: Failed,
    },
    /// The load could not be applied in any parts tried.
    #[error(
        "in {tries} tries with parts of the load down to {part:e} of it no equilibrium was found beyond {reached} of it: \
         the solids may have none there"
    )]
    Load {
        /// Settlings tried.
        tries: usize,
        /// The least part tried.
        part: f64,
        /// The part of the load that still has an equilibrium; the state is that of it.
        reached: f64,
    },
    /// The constraints' forces did not settle, as where a wall leaves no room.
    #[error(
        "the constraints do not settle in {searches} searches: forces still change by {force:e}, the largest violation \
         is {violation:e}; there may be no room for the solids"
    )]
    Unsettled {
        /// Searches made.
        searches: usize,
        /// The last change of a force.
        force: f64,
        /// The largest violation.
        violation: f64,
    },
}

/// Brings `a` to a local minimum of the energy within what the constraints allow.
///
/// Barriers that are to hand over do so after their narrowest width, and the exact equations are solved from there; where
/// that does not converge, they are solved again from a barrier a quarter as wide, four times in all at most, and then the
/// barrier stays: [`Equilibrium::exact`] tells.
///
/// Settled where no constraint's force changes by more than ten times the tolerance of the forces, 1e-7 of the largest load
/// at the default, or by more than rounding, and no constraint is violated by more than 1e-9 of the largest solid.
///
/// # Errors
/// [`NoEquilibrium`]; `a` is then the last state.
pub fn settle(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>) -> Result<Equilibrium, NoEquilibrium> {
    let wanted = newton.settings;
    let result = searches(system, newton, a);
    newton.settings = wanted;
    result
}

/// A state and its terms, to come back to.
type Saved = (Vec<f64>, Vec<Box<dyn Constraint>>);

/// Where the clock stands: only the difference of two is told.
#[allow(clippy::disallowed_methods, reason = "how long it took is no stamp")]
fn clock() -> std::time::Instant {
    std::time::Instant::now()
}

fn searches(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>) -> Result<Equilibrium, NoEquilibrium> {
    let (mut iterations, mut last) = (0, (f64::INFINITY, f64::INFINITY));
    let (wanted, mut polishes, mut saddles, began) = (newton.settings, 0, 0, clock());
    if is_in(system, Stage::Exact) && ready(system) {
        // Nothing else knows how to move what is in exact contact already.
        let polished = follow::follow(system, newton, a);
        iterations += polished.steps;
        if !polished.done {
            return Err(not_converged(&polished));
        }
    }
    for search in 1..=MOST_SEARCHES {
        let provisional = is_in(system, Stage::Provisional);
        newton.settings = on_the_way(wanted, provisional);
        // What leaves a saddle follows the energy, which knows nothing of rows: see `saddle`.
        newton.settings.leave_saddles &= !is_in(system, Stage::Exact);
        let minimum = minimum(system, newton, a).map_err(|cause| NoEquilibrium::Search { search, cause })?;
        iterations += minimum.iterations;
        // Before the update, which replaces the barriers: what a failed polish goes back to.
        let saved: Option<Saved> = provisional.then(|| save(system, a));
        let change = system.update(a);
        last = (change.force, change.violation);
        let settled = change.force <= (10.0 * wanted.tolerance * minimum.load).max(minimum.rounding);
        let free = change.violation <= NO_VIOLATION * system.bodies.extent();
        if settled && free && !change.again {
            let saddle = minimum.stability.falling > 0 && wanted.leave_saddles && saddles < MOST_SADDLES;
            if saddle && ready(system) {
                saddles += 1;
                newton.settings = wanted;
                if let Some(steps) = saddle::leave(system, newton, a) {
                    iterations += steps;
                    continue;
                }
            }
            let found = certified(system, a, minimum, change);
            return Ok(Equilibrium {
                searches: search,
                iterations,
                seconds: began.elapsed().as_secs_f64(),
                ..found
            });
        }
        if polishes < MOST_POLISHES && ready(system) {
            polishes += 1;
            newton.settings = wanted;
            let polished = polish::polish(system, newton, a, aims::Aims::Careful);
            iterations += polished.steps;
            if let (false, Some(saved)) = (polished.done, saved) {
                (*a, system.terms) = saved;
                let contacts = system.terms.iter_mut().filter_map(|t| t.way_to_exact());
                // After the last try the barrier stays for good.
                contacts.for_each(|way| way.narrow(polishes < MOST_POLISHES));
            }
        }
    }
    let (force, violation) = last;
    Err(NoEquilibrium::Unsettled {
        searches: MOST_SEARCHES,
        force,
        violation,
    })
}

/// The state that the energy is least in. What is in exact contact at rest already stays: its rows have no energy that a step could be
/// measured by, and the step after the last digit loses them.
fn minimum(system: &System, newton: &mut Newton, a: &mut Vec<f64>) -> Result<Minimum, Failed> {
    let at_rest = is_in(system, Stage::Exact).then(|| newton.at_rest(system, a)).flatten();
    at_rest.map_or_else(|| newton.minimise(system, a), Ok)
}

/// The refusal of exact contact that has no barrier to go back to.
fn not_converged(polished: &polish::Polished) -> NoEquilibrium {
    let [residual, load] = polished.balance;
    let cause = Failed::NotConverged {
        iterations: polished.steps,
        residual,
        load,
    };
    NoEquilibrium::Search { search: 1, cause }
}

/// The settings of a search; where its term is to be replaced, without what only an end needs.
fn on_the_way(wanted: Settings, provisional: bool) -> Settings {
    let least = if provisional { PROVISIONAL_TOLERANCE } else { 0.0 };
    Settings {
        provisional,
        tolerance: wanted.tolerance.max(least),
        ..wanted
    }
}

/// True where a constraint stands there.
fn is_in(system: &System, stage: Stage) -> bool {
    system.terms.iter().any(|t| t.stage() == stage)
}

/// True where exact contact has taken over from every barrier that is to hand over.
fn ready(system: &mut System) -> bool {
    system.terms.iter_mut().any(|t| t.rows().is_some()) && !is_in(system, Stage::Provisional)
}

fn save(system: &System, a: &[f64]) -> Saved {
    (a.to_vec(), system.terms.iter().map(|t| t.copy()).collect())
}

/// What the state says of itself.
fn certified(system: &System, a: &[f64], minimum: Minimum, change: Change) -> Equilibrium {
    let [complementarity, least, imbalance] = certify::certify(system, a, minimum.load);
    // A violation between the rows is a gap below zero that no force reports.
    let through = if change.violation > 0.0 {
        -change.violation
    } else {
        f64::INFINITY
    };
    Equilibrium {
        minimum,
        force_change: change.force,
        violation: change.violation,
        searches: 0,
        iterations: 0,
        exact: !is_in(system, Stage::FinalBarrier) && !is_in(system, Stage::Provisional),
        complementarity,
        least_gap: least.min(through),
        imbalance,
        load_steps: 1,
        seconds: 0.0,
    }
}

/// [`settle`] with the default settings.
///
/// # Errors
/// [`NoEquilibrium`].
pub fn settled(system: &mut System, a: &mut Vec<f64>) -> Result<Equilibrium, NoEquilibrium> {
    settle(system, &mut Newton::new(Settings::default()), a)
}

/// [`settle`] at the load factor that the system has, by halves of the load where it does not converge at once: each part
/// starts from the state of the one before. At most `tries` settlings.
///
/// # Errors
/// [`NoEquilibrium::Load`] after the last try; `a` and the load factor are then those of the largest part that settled.
pub fn settle_in_steps(
    system: &mut System,
    newton: &mut Newton,
    a: &mut Vec<f64>,
    tries: usize,
) -> Result<Equilibrium, NoEquilibrium> {
    let whole = system.load_factor;
    let (mut reached, mut part, mut steps) = (0.0_f64, 1.0_f64, 0);
    for _ in 0..tries {
        let saved = save(system, a);
        let target = (reached + part).min(1.0);
        system.load_factor = whole * target;
        match settle(system, newton, a) {
            Ok(found) => {
                (reached, steps) = (target, steps + 1);
                if reached >= 1.0 {
                    return Ok(Equilibrium {
                        load_steps: steps,
                        ..found
                    });
                }
            }
            Err(_) => {
                (*a, system.terms) = saved;
                // Back to the last part that has an equilibrium, and half as far from there.
                system.load_factor = whole * reached;
                part *= 0.5;
            }
        }
    }
    Err(NoEquilibrium::Load { tries, part, reached })
}
