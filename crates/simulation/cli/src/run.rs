//! A run: the start, its equilibrium, and the equilibria that follow as walls and instruments move.

mod advance;
mod certificate;
mod contact;
mod criteria;
mod exact;
mod found;
mod moved;
#[cfg(test)]
mod scaled;
mod settle;
mod stopwatch;
#[cfg(test)]
mod tests;

pub(crate) use certificate::State;
pub(crate) use contact::Contact;
pub(crate) use criteria::Measures;
pub(crate) use stopwatch::Stopwatch;

use crate::model::Model;
use crate::scene::raw::RawSearch;
use moved::Moved;
use settle::Searcher;

/// What a run found.
#[derive(Debug)]
pub(crate) struct Run {
    /// States in the order in which they came, the start first.
    pub(crate) states: Vec<State>,
    /// Why it ended early.
    pub(crate) refused: Option<String>,
}

/// Runs a model. `tell` gets a line for each state.
pub(crate) fn run(model: &mut Model, search: &RawSearch, tell: &mut dyn FnMut(&str)) -> Run {
    let mut states = vec![State::placed(model, "as placed", model.placed.clone())];
    if model.start != model.placed {
        states.push(State::placed(model, "moved apart", model.start.clone()));
    }
    let mut run = Run { states, refused: None };
    if search.settle {
        run.refused = settled(model, search, &mut run.states, tell).err();
    }
    run
}

fn settled(
    model: &mut Model,
    search: &RawSearch,
    states: &mut Vec<State>,
    tell: &mut dyn FnMut(&str),
) -> Result<(), String> {
    let mut searcher = Searcher::new(search.most_steps, search.exact);
    let mut a = model.start.clone();
    let first = searcher.first(model, &mut a, search.watch, states);
    let state = first.map_err(|why| {
        // The last state is shown, as what it is.
        states.push(State::placed(model, "NOT an equilibrium", a.clone()));
        format!("finding the first equilibrium: {why}")
    })?;
    tell(&state.line());
    states.push(state);
    let total: usize = model.steps.iter().map(|s| s.frames).sum();
    let mut frame = 0;
    for step in model.steps.clone() {
        for _ in 0..step.frames {
            frame += 1;
            let label = format!("frame {frame} of {total}");
            let state = searcher.frame(model, &mut a, &step.moves, &label).map_err(|why| {
                states.push(State::placed(model, &format!("NOT an equilibrium, {label}"), a.clone()));
                format!("{label}: {why}")
            })?;
            tell(&state.line());
            states.push(state);
        }
    }
    Ok(())
}

impl Run {
    /// Labels of the equilibria whose certificate does not hold, each with why.
    pub(crate) fn uncertified(&self) -> Vec<String> {
        let fails = |state: &State| {
            let fails = state.measures.as_ref().map(Measures::fails).unwrap_or_default();
            (!fails.is_empty()).then(|| format!("{}: {}", state.label, fails.join("; ")))
        };
        self.states.iter().filter_map(fails).collect()
    }
}

impl State {
    /// A line about it.
    fn line(&self) -> String {
        let Some(measures) = &self.measures else {
            return self.label.clone();
        };
        let mut parts = vec![format!("{} steps, {:.1} ms", self.iterations, self.milliseconds)];
        parts.push(measures.words());
        parts.extend(self.moved.iter().filter(|m| m.limited()).map(Moved::words));
        let fails = measures.fails();
        if !fails.is_empty() {
            parts.push(format!("NOT certified: {}", fails.join(", ")));
        }
        format!("{}: {}", self.label, parts.join("; "))
    }
}
