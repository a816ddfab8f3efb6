//! Equilibrium under constraints: searches, with the terms of the constraints brought up to date between them.

use crate::control::{Failed, Minimum, Newton, Settings};
use crate::system::System;

/// The most searches of one equilibrium.
const MOST_SEARCHES: usize = 60;
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
/// Settled where no constraint's force changes by more than the tolerance of the forces, 1e-8 of the largest load at the
/// default, and no constraint is violated by more than 1e-9 of the largest solid.
///
/// # Errors
/// [`NoEquilibrium`]; `a` is then the last state.
pub fn settle(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>) -> Result<Equilibrium, NoEquilibrium> {
    let (mut iterations, mut last) = (0, (f64::INFINITY, f64::INFINITY));
    let wanted = newton.settings;
    for search in 1..=MOST_SEARCHES {
        let found = newton.minimise(system, a);
        let minimum = found.map_err(|cause| NoEquilibrium::Search { search, cause })?;
        iterations += minimum.iterations;
        let change = system.update(a);
        last = (change.force, change.violation);
        let settled = change.force <= 10.0 * wanted.tolerance * minimum.load;
        let free = change.violation <= NO_VIOLATION * system.bodies.extent();
        if settled && free && !change.again {
            return Ok(Equilibrium {
                minimum,
                force_change: change.force,
                violation: change.violation,
                searches: search,
                iterations,
            });
        }
    }
    let (force, violation) = last;
    Err(NoEquilibrium::Unsettled {
        searches: MOST_SEARCHES,
        force,
        violation,
    })
}

/// [`settle`] with the default settings.
///
/// # Errors
/// [`NoEquilibrium`].
pub fn settled(system: &mut System, a: &mut Vec<f64>) -> Result<Equilibrium, NoEquilibrium> {
    settle(system, &mut Newton::new(Settings::default()), a)
}
