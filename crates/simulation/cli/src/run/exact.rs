//! The end of a frame: exact contact, found from the state behind the barriers.
//!
//! The state behind the barriers is kept: the next frame begins with it, where every gap has room.

use simulation::constraint::Constraint;
use simulation::equilibrium::settle;

use super::State;
use super::found::Found;
use super::settle::Searcher;
use super::stopwatch::Stopwatch;
use crate::model::Model;

impl Searcher {
    /// The state that a frame ends with: in exact contact where that is wanted and found, else `a` as it is, which its
    /// certificate then says.
    pub(super) fn finish(&mut self, model: &mut Model, label: &str, a: &[f64], found: Found) -> State {
        if !self.exact {
            return State::settled(model, label, a, found);
        }
        let barriers: Vec<Box<dyn Constraint>> = model.system.terms.iter().map(|t| t.copy()).collect();
        let (began, mut touching) = (Stopwatch::start(), a.to_vec());
        let contacts = model.system.terms.iter_mut().filter_map(|t| t.way_to_exact());
        contacts.for_each(|way| way.want_exact());
        let settled = settle(&mut model.system, &mut self.newton, &mut touching);
        let found = Found {
            wanted_exact: true,
            milliseconds: found.milliseconds + began.ms(),
            ..found
        };
        let state = match settled {
            Ok(equilibrium) if equilibrium.exact => {
                let iterations = found.iterations + equilibrium.iterations;
                let found = Found {
                    equilibrium,
                    iterations,
                    ..found
                };
                State::settled(model, label, &touching, found)
            }
            _ => {
                model.system.terms = barriers.iter().map(|t| t.copy()).collect();
                State::settled(model, label, a, found)
            }
        };
        model.system.terms = barriers;
        state
    }
}
