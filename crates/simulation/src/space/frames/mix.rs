//! Anderson's mixing of steps (1965): the combination of the last ones that leaves the least.

use nalgebra::{DMatrix, DVector};

/// Steps that are mixed at most.
const DEPTH: usize = 4;

/// States and the steps made from them.
#[derive(Debug, Clone, Default)]
pub(super) struct Mix {
    last: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Mix {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.last.clear();
    }

    /// The step to make from `a`, where the model says `step`; `None` without others to mix it with.
    pub(super) fn next(&mut self, a: &[f64], step: &[f64]) -> Option<Vec<f64>> {
        let count = self.last.len();
        let mixed = (count > 0).then(|| self.mixed(a, step)).flatten();
        if count == DEPTH {
            self.last.remove(0);
        }
        self.last.push((a.to_vec(), step.to_vec()));
        mixed
    }

    /// `step - sum of g_j ((a - a_j) + (step - step_j))` with the `g` for which `step - sum of g_j (step - step_j)` is shortest.
    fn mixed(&self, a: &[f64], step: &[f64]) -> Option<Vec<f64>> {
        let count = self.last.len();
        let differences: Vec<Vec<f64>> = self.last.iter().map(|(_, old)| less(step, old)).collect();
        let gram = DMatrix::from_fn(count, count, |i, j| dot(&differences[i], &differences[j]));
        let right = DVector::from_fn(count, |i, _| dot(&differences[i], step));
        // Steps that are nearly alike: what their difference does not tell counts as nothing.
        let held = 1e-12 * gram.trace() / count as f64;
        let factor = (gram + DMatrix::identity(count, count) * held).cholesky()?;
        let parts = factor.solve(&right);
        let mut mixed = step.to_vec();
        for ((old, _), (difference, part)) in self.last.iter().zip(differences.iter().zip(parts.iter())) {
            for (((mixed, a), old), difference) in mixed.iter_mut().zip(a).zip(old).zip(difference) {
                *mixed -= part * (a - old + difference);
            }
        }
        Some(mixed)
    }
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
