//! Uncertain numbers of a scene as forces on a state: what one standard deviation of each does to the balance, to first order.
//!
//! A state `a` is in balance, `F(a, p) = 0`. What a number `p` with standard deviation `s` does to it follows from `s dF/dp` at the state alone
//! (`simulation::space::frames::Yielding`); this module knows that derivative.

use simulation::control::Potential;
use simulation::space::system::System;

use super::labels::Labels;
use super::model::Model;
use super::plan::{Plan, Uncertain};
use crate::numbers::Checked;

/// A number with a standard deviation, and the systems whose forces tell its derivative.
#[derive(Debug)]
pub struct Varied {
    /// The number.
    pub of: Uncertain,
    systems: Vec<(System, f64)>,
}

impl Varied {
    /// All numbers of a plan that have a standard deviation, with systems of the same meshes as the model's.
    ///
    /// # Errors
    /// As [`Model::changed`].
    pub fn all(model: &Model, plan: &Plan, labels: &Labels) -> Checked<Vec<Self>> {
        let each = plan.uncertain().into_iter().map(|of| {
            let mut systems = Vec::new();
            for (value, weight) in of.slope() {
                // A number next to one that was checked is one, too.
                if let Some(plan) = plan.with(&of, value) {
                    systems.push((model.changed(&plan, labels)?.system, weight));
                }
            }
            Ok(Self { of, systems })
        });
        each.collect()
    }

    /// The forces on the unknowns, N, downhill, that one standard deviation of the number adds at a state, to first order. `None` where a system has no
    /// energy there.
    pub fn forces(&self, a: &[f64]) -> Option<Vec<f64>> {
        let (mut sum, mut gradient) = (vec![0.0; a.len()], vec![0.0; a.len()]);
        for (system, weight) in &self.systems {
            // Loads and weights are alike in all of them: the weights sum to zero, and leave what the number does.
            system.gradient(a, &mut gradient)?;
            sum.iter_mut().zip(&gradient).for_each(|(sum, g)| *sum -= weight * g);
        }
        Some(sum)
    }
}
