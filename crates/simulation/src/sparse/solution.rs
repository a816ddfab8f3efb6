//! Solutions with a factor: whole, and by way of the root that is eliminated last.

use nalgebra::DMatrix;

use super::Ldl;

/// A right side that was reduced to the root.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// In the order of elimination.
    x: Vec<f64>,
    kept: usize,
}

impl Reduced {
    /// What is left of the right side on the root, in the order of the root's unknowns.
    pub fn on_root(&self) -> &[f64] {
        &self.x[self.x.len() - self.kept..]
    }
}

impl Ldl {
    /// A direction `v` with `v^T A v < 0`, from the first negative pivot of the matrix `A` factored last: `L^T v = e_k`, which
    /// asks for the columns before that pivot only.
    pub fn falling_direction(&self) -> Option<Vec<f64>> {
        let s = &self.symbolic;
        // `v^T A v = d_k < 0` for `L^T v = e_k`. Columns after the first negative pivot may not be eliminated; `e_k`
        // has no part in them.
        let first = self.store.pivots().iter().position(|pivot| *pivot < 0.0)?;
        let mut x = vec![0.0; s.order.len()];
        x[first] = 1.0;
        // Fronts after this one may hold anything.
        self.store.back(s, 0..s.front_of(first) + 1, &mut x);
        let mut direction = vec![0.0; x.len()];
        for (i, value) in s.order.iter().zip(x) {
            direction[*i as usize] = value;
        }
        Some(direction)
    }

    /// Solves with the matrix factored last; `b` becomes the solution.
    pub fn solve(&self, b: &mut [f64]) {
        let order = &self.symbolic.order;
        let mut x: Vec<f64> = order.iter().map(|i| b[*i as usize]).collect();
        let fronts = self.symbolic.fronts.len();
        self.store.forward(&self.symbolic, 0..fronts, &mut x);
        self.store.back(&self.symbolic, 0..fronts, &mut x);
        for (i, value) in order.iter().zip(x) {
            b[*i as usize] = value;
        }
    }

    /// The root's unknowns, in the order in which they were named, and the Schur complement on them of the matrix factored last:
    /// `S = A_rr - A_ri A_ii^-1 A_ir`, the others being `i`. `S y = Reduced::on_root` is what a solution demands of the root's part `y`.
    /// Of the shifted matrix where there was a shift. It is there also where [`Self::factor`] found no pivot in the root; empty without a
    /// root, and of no use where [`Self::definite`] said no.
    pub fn root(&self) -> (&[u32], &DMatrix<f64>) {
        let order = &self.symbolic.order;
        (&order[order.len() - self.symbolic.kept..], &self.root)
    }

    /// The first half of a solution of `A x = b`: down to the root.
    pub fn reduce(&self, b: &[f64]) -> Reduced {
        let mut x: Vec<f64> = self.symbolic.order.iter().map(|i| b[*i as usize]).collect();
        let fronts = 0..self.above_root();
        self.store.forward(&self.symbolic, fronts, &mut x);
        Reduced {
            x,
            kept: self.symbolic.kept,
        }
    }

    /// The second half, with the root's unknowns `y` known: all unknowns.
    pub fn back(&self, reduced: &Reduced, y: &[f64]) -> Vec<f64> {
        let mut x = reduced.x.clone();
        let first = x.len() - self.symbolic.kept;
        x[first..].copy_from_slice(y);
        let fronts = 0..self.above_root();
        self.store.back(&self.symbolic, fronts, &mut x);
        let mut all = vec![0.0; x.len()];
        for (i, value) in self.symbolic.order.iter().zip(x) {
            all[*i as usize] = value;
        }
        all
    }

    /// Fronts but the root's.
    fn above_root(&self) -> usize {
        self.symbolic.fronts.len() - usize::from(self.symbolic.kept > 0)
    }
}
