//! The state in which all forces balance, contact exact.

use super::level_set::Unproved;
use super::system::System;
use super::term::MOST_INSIDE;
use crate::control::{Failed, Newton};

/// Rounds of pressures at most.
const MOST_ROUNDS: usize = 60;
/// Free forces that a round may leave: this part of the change that the round before made of contacts' forces, and at first of the load.
const LEFT_BY_ROUND: f64 = 1e-2;
const LEFT_AT_FIRST: f64 = 1e-4;

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Change of a contact's force on an unknown in the last round beside the largest force of a point.
    pub change: f64,
    /// Depth of a point in what it must stay out of, beside the largest solid.
    pub depth: f64,
}

impl Default for Tolerance {
    /// A millionth of the force and of the size.
    fn default() -> Self {
        Self {
            change: 1e-6,
            depth: 1e-6,
        }
    }
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium {
    /// Energy of solids, weights, loads and springs; of contacts nothing is left.
    pub energy: f64,
    /// The largest free force, and what it is measured by.
    pub residual: f64,
    /// The largest load or reaction.
    pub load: f64,
    /// Change of a contact's force in the last round.
    pub change: f64,
    /// The deepest point in what it must stay out of, mm.
    pub depth: f64,
    /// The least determinant of the deformation gradient at the points of the elements.
    pub least_determinant: f64,
    /// Rounds of pressures.
    pub rounds: usize,
    /// Steps of Newton's method in all of them.
    pub iterations: usize,
    /// Directions in which the energy falls: 0 at a minimum. `None`, not known, where the search was asked for provisional states.
    pub falling: Option<usize>,
}

/// Why no state was found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoEquilibrium {
    /// A search failed.
    #[error("in round {round} of the contact's pressures: {failed}")]
    Search {
        /// From 1.
        round: usize,
        /// Why.
        failed: Failed,
    },
    /// A tube, an obstacle or another organ was put too far into the tissue at once.
    #[error(
        "a point is {depth:.3} mm deep in what it must stay out of; deeper than {most:.3} mm it might leave on the other side: move tubes by shorter ways"
    )]
    TooDeep {
        /// Depth, mm.
        depth: f64,
        /// The most, half the radius of the tube or of the ball that fits into the obstacle.
        most: f64,
    },
    /// The mesh is too coarse for a tube or an obstacle.
    #[error(
        "points of the surface at a contact are {gap:.3} mm apart from the middle between them; what has a radius of twice {most:.3} mm may lie unseen there: use smaller cubes at it"
    )]
    TooCoarse {
        /// The widest gap, mm.
        gap: f64,
        /// The most, half the radius of the tube or of the ball that fits into the obstacle.
        most: f64,
    },
    /// Something has come through the surface between its points, which press on it no more.
    #[error(
        "a point inside the tissue is {depth:.3} mm deep in what it must stay out of; more than {most:.3} mm says that this has come through the surface between its points: use smaller cubes at it, or a shorter way"
    )]
    Through {
        /// Depth, mm.
        depth: f64,
        /// The most: half the radius at the start, a fifth of it in a state that is found.
        most: f64,
    },
    /// The surface may have met what was not looked at, or an edge that is thinner than the ball.
    #[error("{0}")]
    Unproved(Unproved),
    /// Pressures do not settle.
    #[error(
        "the contact's pressures still change by {change:.2e} beside {load:.2e}, and points are {depth:.2e} mm deep, after {MOST_ROUNDS} rounds"
    )]
    Pressures {
        /// Change of a force.
        change: f64,
        /// The largest force.
        load: f64,
        /// Depth, mm.
        depth: f64,
    },
}

/// Moves `a` to the state in which forces balance and contacts are exact.
///
/// # Errors
/// [`NoEquilibrium`]. `a` and the contacts are then as far as the search came.
pub fn settle(
    system: &mut System,
    newton: &mut Newton,
    a: &mut Vec<f64>,
    tolerance: &Tolerance,
) -> Result<Equilibrium, NoEquilibrium> {
    fits(system, a, 1.0)?;
    let wanted = newton.settings;
    let found = by_rounds(system, newton, a, tolerance);
    newton.settings = wanted;
    found
}

fn by_rounds(
    system: &mut System,
    newton: &mut Newton,
    a: &mut Vec<f64>,
    tolerance: &Tolerance,
) -> Result<Equilibrium, NoEquilibrium> {
    let wanted = newton.settings;
    let (mut iterations, mut last, mut left) = (0, (0.0, 0.0, 0.0), 0.0);
    if system.terms().any(|term| term.changes()) {
        left = LEFT_AT_FIRST;
    }
    for round in 1..=MOST_ROUNDS {
        // Pressures stand still while forces are balanced, and change between: either alone is a smooth problem. Balance to all digits is for
        // pressures that stay: with those of a tube that has just been moved it may take hundreds of steps, and is of no use.
        let is_last = left <= wanted.tolerance;
        newton.settings.tolerance = left.max(wanted.tolerance);
        newton.settings.provisional = wanted.provisional || !is_last;
        let found = newton.minimise(system, a);
        let found = found.map_err(|failed| NoEquilibrium::Search { round, failed })?;
        iterations += found.iterations;
        let change = system.update(a);
        last = (change.force, found.load, change.depth);
        // Small changes alone could be slow ones: no depth may be left.
        let settled =
            change.force <= tolerance.change * found.load && change.depth <= tolerance.depth * system.bodies.extent();
        if settled && is_last {
            // What was far away at the start may be met by now, by points too far apart; or have come through between them.
            fits(system, a, MOST_INSIDE)?;
            return Ok(Equilibrium {
                energy: found.energy,
                residual: found.residual,
                load: found.load,
                change: change.force,
                depth: change.depth,
                least_determinant: found.least_determinant,
                rounds: round,
                iterations,
                falling: (!wanted.provisional).then_some(found.stability.falling),
            });
        }
        left = match settled {
            true => 0.0,
            false => left.min(LEFT_BY_ROUND * change.force / found.load),
        };
    }
    let (change, load, depth) = last;
    Err(NoEquilibrium::Pressures { change, load, depth })
}

/// Refuses contacts that are too deep to be led out again, that the points of a surface may not see, or (points inside deeper than this part
/// of the deepest) that have come through it.
fn fits(system: &System, a: &[f64], inside_part: f64) -> Result<(), NoEquilibrium> {
    for fit in system.terms().filter_map(|term| term.fit(&system.bodies, a)) {
        let (depth, gap, most) = (fit.depth, fit.gap, fit.deepest);
        // At the most no step could leave any more. Of what is no number the search itself says that it has no energy.
        if depth >= most && depth.is_finite() {
            return Err(NoEquilibrium::TooDeep { depth, most });
        }
        if gap > most {
            return Err(NoEquilibrium::TooCoarse { gap, most });
        }
        let (depth, most) = (fit.inside, inside_part * most);
        if depth > most && depth.is_finite() {
            return Err(NoEquilibrium::Through { depth, most });
        }
        if let Some(why) = fit.unproved {
            return Err(NoEquilibrium::Unproved(why));
        }
    }
    Ok(())
}
