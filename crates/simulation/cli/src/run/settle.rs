//! Equilibria of a model, one after the other.

use simulation::control::{Failed, Newton, Settings};
use simulation::equilibrium::{NoEquilibrium, settle};

use super::State;
use super::found::Found;
use super::stopwatch::Stopwatch;
use crate::model::Model;

/// States kept of a search that is watched.
const MOST_WATCHED: usize = 200;

/// Searches with the memory of those before.
pub(super) struct Searcher {
    pub(super) newton: Newton,
    pub(super) most: usize,
    /// Frames end with exact contact.
    pub(super) exact: bool,
}

impl Searcher {
    pub(super) fn new(most: usize, exact: bool) -> Self {
        let settings = Settings {
            most_iterations: most,
            ..Settings::default()
        };
        Self {
            newton: Newton::new(settings),
            most,
            exact,
        }
    }

    /// The equilibrium next to a start that may be far; with `watch`, states on the way go to `states`.
    pub(super) fn first(
        &mut self,
        model: &mut Model,
        a: &mut Vec<f64>,
        watch: Option<usize>,
        states: &mut Vec<State>,
    ) -> Result<State, String> {
        let makers = model.constrain(true);
        let began = Stopwatch::start();
        let mut steps = 0;
        if let Some(every) = watch {
            steps = self.watched(model, a, every.max(1), states);
        }
        let inverts = model.inverts;
        let found = settle(&mut model.system, &mut self.newton, a).map_err(|why| explained(&why, inverts))?;
        let found = Found {
            iterations: steps + found.iterations,
            equilibrium: found,
            makers,
            wanted_exact: false,
            milliseconds: began.ms(),
        };
        Ok(self.finish(model, "at rest", a, found))
    }

    /// Lets the search go on a few steps at a time, and keeps the states between; at most half of the steps allowed.
    fn watched(&mut self, model: &mut Model, a: &mut Vec<f64>, every: usize, states: &mut Vec<State>) -> usize {
        let mut steps = 0;
        self.newton.settings.most_iterations = every;
        while steps < self.most / 2 {
            let stopped = settle(&mut model.system, &mut self.newton, a);
            if !matches!(
                stopped,
                Err(NoEquilibrium::Search {
                    cause: Failed::NotConverged { .. },
                    ..
                })
            ) {
                break;
            }
            steps += every;
            if states.len() < MOST_WATCHED {
                states.push(State::placed(model, &format!("after {steps} steps"), a.clone()));
            }
        }
        self.newton.settings.most_iterations = self.most;
        steps
    }

    /// The equilibrium after a small change.
    pub(super) fn next(&mut self, model: &mut Model, a: &mut Vec<f64>) -> Result<Found, String> {
        let makers = model.constrain(false);
        let began = Stopwatch::start();
        let inverts = model.inverts;
        let equilibrium = settle(&mut model.system, &mut self.newton, a).map_err(|why| explained(&why, inverts))?;
        Ok(Found {
            iterations: equilibrium.iterations,
            equilibrium,
            makers,
            wanted_exact: false,
            milliseconds: began.ms(),
        })
    }
}

/// The reason, with what a person can do about it; another law where a solid has one that `inverts`.
fn explained(why: &NoEquilibrium, inverts: bool) -> String {
    let advice = match why {
        NoEquilibrium::Search {
            cause: Failed::NoEnergy,
            ..
        } => "Check that solids neither touch nor overlap at the start",
        NoEquilibrium::Search {
            cause: Failed::Unbounded { .. },
            ..
        } => "Give what falls a wall, a link or held nodes to come to rest on",
        NoEquilibrium::Search {
            cause: Failed::NotConverged { .. },
            ..
        } if inverts => "Raise search.most_steps, use law = \"neo-hookean\", smaller weights or smaller moves",
        NoEquilibrium::Search {
            cause: Failed::NotConverged { .. },
            ..
        } => "Raise search.most_steps, use smaller weights or smaller moves, or a finer mesh where it is crushed",
        NoEquilibrium::Search {
            cause: Failed::Inverted { .. },
            ..
        } if inverts => "Use law = \"neo-hookean\", which forbids it, or smaller weights or moves",
        NoEquilibrium::Search {
            cause: Failed::Inverted { .. },
            ..
        } => "Use smaller weights or smaller moves, or a finer mesh where it is crushed",
        NoEquilibrium::Unsettled { .. } => "Leave the solids more room, or use search.walls = \"barrier\"",
        #[allow(unreachable_patterns, reason = "refusals may be added")]
        _ => "Use smaller moves",
    };
    format!("{why}. {advice}")
}
