//! Anderson's mixing of steps (1965): the combination of the last ones that leaves the least.

use nalgebra::{DMatrix, DVector};

/// Steps that are mixed at most.
const DEPTH: usize = 4;

/// A state, the step that a model makes from it, and the pressures there.
#[derive(Debug, Clone)]
struct Made {
    a: Vec<f64>,
    step: Vec<f64>,
    pressures: Vec<f64>,
}

/// The last steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Mix {
    last: Vec<Made>,
}

impl Mix {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.last.clear();
    }

    /// The step to make from `a`, with its pressures, where the model says `step` and `pressures`; `None` without others to mix it with.
    pub(super) fn next(&mut self, a: &[f64], step: &[f64], pressures: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let mixed = if self.last.is_empty() {
            None
        } else {
            self.mixed(a, step, pressures)
        };
        if self.last.len() == DEPTH {
            self.last.remove(0);
        }
        self.last.push(Made {
            a: a.to_vec(),
            step: step.to_vec(),
            pressures: pressures.to_vec(),
        });
        mixed
    }

    /// `step - sum of g_j ((a - a_j) + (step - step_j))` with the `g` for which `step - sum of g_j (step - step_j)` is shortest; pressures
    /// likewise.
    fn mixed(&self, a: &[f64], step: &[f64], pressures: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let count = self.last.len();
        // Differences to the newest: the constraint that parts sum to one is then in the form itself.
        let differences: Vec<Vec<f64>> = self.last.iter().map(|old| less(step, &old.step)).collect();
        let gram = DMatrix::from_fn(count, count, |i, j| dot(&differences[i], &differences[j]));
        let right = DVector::from_fn(count, |i, _| dot(&differences[i], step));
        // Steps that are nearly alike: what their difference does not tell counts as nothing.
        let held = 1e-12 * gram.trace() / count as f64;
        let factor = (gram + DMatrix::identity(count, count) * held).cholesky()?;
        let parts = factor.solve(&right);
        let (mut mixed, mut pressing) = (step.to_vec(), pressures.to_vec());
        for ((old, difference), part) in self.last.iter().zip(&differences).zip(parts.iter()) {
            for (((mixed, a), old), difference) in mixed.iter_mut().zip(a).zip(&old.a).zip(difference) {
                *mixed -= part * (a - old + difference);
            }
            for ((pressing, new), old) in pressing.iter_mut().zip(pressures).zip(&old.pressures) {
                *pressing -= part * (new - old);
            }
        }
        // What presses no more by the last step does not by any mixture.
        for (pressing, new) in pressing.iter_mut().zip(pressures) {
            *pressing = if *new > 0.0 { pressing.max(0.0) } else { 0.0 };
        }
        Some((mixed, pressing))
    }
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
