//! `L D L^T` of a sparse symmetric matrix.

use super::Triplets;
use super::symbolic::Symbolic;

/// A pivot below this part of the diagonal entry that it comes from counts as zero: what is left is rounding.
const ZERO_PIVOT: f64 = 1e-14;

/// Patterns that are joined before the oldest are forgotten.
const MOST_JOINED: usize = 8;

/// The signs of the pivots, which are those of the eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inertia {
    /// Pivots above zero.
    pub positive: usize,
    /// Pivots below zero.
    pub negative: usize,
}

/// A pivot vanished: the matrix, or a leading block of it, is singular.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the pivot of unknown {unknown} is {pivot:e}, nothing beside its diagonal entry {diagonal:e}: the matrix is singular"
)]
pub struct NoPivot {
    /// The unknown whose pivot it is.
    pub unknown: usize,
    /// The pivot.
    pub pivot: f64,
    /// The diagonal entry that it comes from.
    pub diagonal: f64,
}

/// A factorisation that remembers the pattern it met last, so that a matrix of the same pattern costs no search.
#[derive(Debug, Clone, Default)]
pub struct Ldl {
    places: Vec<(u32, u32)>,
    /// The entry that each triplet adds to.
    slots: Vec<u32>,
    /// The places that the elimination was found for: those of several matrices.
    pattern: Vec<(u32, u32)>,
    joined: usize,
    symbolic: Symbolic,
    entries: Vec<f64>,
    lower: Vec<f64>,
    pivots: Vec<f64>,
    filled: Vec<usize>,
    work: Vec<f64>,
}

impl Ldl {
    /// A factorisation of nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Factors `matrix + shift I`. Without pivoting: exact for definite matrices, and for others while no leading block
    /// in the order of elimination is near singular; [`Self::solve`]'s residual tells.
    ///
    /// # Errors
    /// [`NoPivot`], also where an entry is not a number.
    pub fn factor(&mut self, matrix: &Triplets, shift: f64) -> Result<Inertia, NoPivot> {
        let size = matrix.size();
        if self.places != matrix.places || self.symbolic.order.len() != size {
            self.learn(size, &matrix.places);
        }
        self.gather(matrix, shift);
        self.eliminate(size)
    }

    /// Where the entries of a new pattern go. Contacts come and go: the elimination is kept while it has a place for each,
    /// and found anew for both patterns together where it has not.
    fn learn(&mut self, size: usize, places: &[(u32, u32)]) {
        let known = self.symbolic.order.len() == size && size > 0;
        let kept = known.then(|| self.symbolic.slots(places)).flatten();
        self.slots = kept.unwrap_or_else(|| {
            if !known || self.joined >= MOST_JOINED {
                self.pattern.clear();
                self.joined = 0;
            }
            self.joined += 1;
            self.pattern.extend_from_slice(places);
            self.pattern.sort_unstable();
            self.pattern.dedup();
            self.symbolic = Symbolic::new(size, &self.pattern);
            // Every place was put in above.
            self.symbolic.slots(places).unwrap_or_default()
        });
        self.places.clear();
        self.places.extend_from_slice(places);
    }

    /// Entries of `L` below the diagonal.
    pub fn fill(&self) -> usize {
        self.lower.len()
    }

    /// Multiplications of a factorisation.
    pub fn work(&self) -> usize {
        let columns = self.symbolic.column_start.windows(2).map(|w| w[1] - w[0]);
        columns.map(|c| c * (c + 3) / 2).sum()
    }

    fn gather(&mut self, matrix: &Triplets, shift: f64) {
        let s = &self.symbolic;
        self.entries.clear();
        self.entries.resize(s.entry_rows.len(), 0.0);
        for (slot, value) in self.slots.iter().zip(&matrix.values) {
            self.entries[*slot as usize] += value;
        }
        // The diagonal closes each sorted column of the upper triangle.
        for end in &s.entry_start[1..] {
            self.entries[end - 1] += shift;
        }
    }

    /// Row by row: `L` up to row k - 1 gives row k by a triangular solve.
    fn eliminate(&mut self, size: usize) -> Result<Inertia, NoPivot> {
        let s = &self.symbolic;
        self.lower.resize(s.column_rows.len(), 0.0);
        self.pivots.resize(size, 0.0);
        self.filled.clone_from(&s.column_start);
        self.work.clear();
        self.work.resize(size, 0.0);
        let (y, mut inertia) = (&mut self.work, Inertia::default());
        for k in 0..size {
            for e in s.entry_start[k]..s.entry_start[k + 1] {
                y[s.entry_rows[e] as usize] = self.entries[e];
            }
            let diagonal = std::mem::take(&mut y[k]);
            let mut pivot = diagonal;
            for &column in &s.row_columns[s.row_start[k]..s.row_start[k + 1]] {
                let column = column as usize;
                let value = std::mem::take(&mut y[column]);
                let (start, end) = (s.column_start[column], self.filled[column]);
                for (row, l) in s.column_rows[start..end].iter().zip(&self.lower[start..end]) {
                    y[*row as usize] -= l * value;
                }
                let l = value / self.pivots[column];
                pivot -= l * value;
                self.lower[end] = l;
                self.filled[column] = end + 1;
            }
            if pivot.is_nan() || pivot.abs() <= ZERO_PIVOT * diagonal.abs() {
                let unknown = s.order[k] as usize;
                return Err(NoPivot {
                    unknown,
                    pivot,
                    diagonal,
                });
            }
            self.pivots[k] = pivot;
            if pivot > 0.0 {
                inertia.positive += 1
            } else {
                inertia.negative += 1
            }
        }
        Ok(inertia)
    }

    /// A direction `v` with `v^T A v < 0`, from the first negative pivot of the matrix `A` factored last: `L^T v = e_k`.
    pub fn falling_direction(&self) -> Option<Vec<f64>> {
        let s = &self.symbolic;
        let first = self.pivots.iter().position(|pivot| *pivot < 0.0)?;
        let mut x = vec![0.0; s.order.len()];
        x[first] = 1.0;
        self.solve_transposed(&mut x);
        let mut direction = vec![0.0; x.len()];
        for (i, value) in s.order.iter().zip(x) {
            direction[*i as usize] = value;
        }
        Some(direction)
    }

    /// `L^T x = b` in the order of elimination.
    fn solve_transposed(&self, x: &mut [f64]) {
        let s = &self.symbolic;
        for (k, range) in s.column_start.windows(2).map(|w| w[0]..w[1]).enumerate().rev() {
            let below = s.column_rows[range.clone()].iter().zip(&self.lower[range]);
            x[k] -= below.map(|(row, l)| l * x[*row as usize]).sum::<f64>();
        }
    }

    /// Solves with the matrix factored last; `b` becomes the solution.
    pub fn solve(&self, b: &mut [f64]) {
        let s = &self.symbolic;
        let mut x: Vec<f64> = s.order.iter().map(|i| b[*i as usize]).collect();
        for (k, range) in s.column_start.windows(2).map(|w| w[0]..w[1]).enumerate() {
            let value = x[k];
            for (row, l) in s.column_rows[range.clone()].iter().zip(&self.lower[range]) {
                x[*row as usize] -= l * value;
            }
        }
        for (value, pivot) in x.iter_mut().zip(&self.pivots) {
            *value /= pivot;
        }
        self.solve_transposed(&mut x);
        for (i, value) in s.order.iter().zip(x) {
            b[*i as usize] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// A symmetric matrix of the pattern of a `side` x `side` grid of pairs, diagonal `diagonal`.
    fn grid(side: usize, diagonal: f64, seed: u64) -> (Triplets, DMatrix<f64>) {
        let n = 2 * side * side;
        let mut triplets = Triplets::new(n);
        let mut dense = DMatrix::zeros(n, n);
        let mut state = seed;
        for i in 0..n {
            for j in 0..=i {
                let (a, b) = (i / 2, j / 2);
                let near = (a % side).abs_diff(b % side) <= 1 && (a / side).abs_diff(b / side) <= 1;
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                if near {
                    let value = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
                    let value = if i == j { value + diagonal } else { value };
                    // In two parts, so that repetitions must add up.
                    triplets.add(i, j, 0.25 * value);
                    triplets.add(j, i, 0.75 * value);
                    dense[(i, j)] = value;
                    dense[(j, i)] = value;
                }
            }
        }
        (triplets, dense)
    }

    #[test]
    fn solutions_and_signs_agree_with_dense_algebra() {
        // 20: definite. 0.3 and -2: indefinite, with the signs of the dense eigenvalues.
        for (diagonal, side) in [(20.0, 1), (20.0, 6), (2.0, 7), (-2.0, 5), (-20.0, 6)] {
            let (triplets, dense) = grid(side, diagonal, 42);
            let mut ldl = Ldl::new();
            let inertia = ldl.factor(&triplets, 0.0).unwrap();
            let eigen = dense.clone().symmetric_eigenvalues();
            assert_eq!(inertia.negative, eigen.iter().filter(|v| **v < 0.0).count());
            assert_eq!(inertia.positive + inertia.negative, triplets.size());
            let x = DVector::from_fn(triplets.size(), |i, _| (i as f64).sin());
            let mut b: Vec<f64> = (&dense * &x).as_slice().to_vec();
            assert!((DVector::from_vec(triplets.product(x.as_slice())) - &dense * &x).amax() < 1e-13);
            ldl.solve(&mut b);
            // Rounding times the condition and the growth of a factorisation without pivoting.
            let bound = if diagonal.abs() > 5.0 { 1e-13 } else { 1e-9 };
            assert!((DVector::from_vec(b) - x).amax() < bound, "{diagonal} {side}");
        }
    }

    #[test]
    fn a_shift_moves_the_eigenvalues() {
        let (triplets, dense) = grid(4, 0.0, 9);
        for shift in [-1.5, -0.4, 0.4, 1.5] {
            let inertia = Ldl::new().factor(&triplets, shift).unwrap();
            let eigen = dense.clone().symmetric_eigenvalues();
            assert_eq!(
                inertia.negative,
                eigen.iter().filter(|v| **v + shift < 0.0).count(),
                "{shift}"
            );
        }
    }

    #[test]
    fn a_pattern_met_before_gives_the_same_as_a_new_one() {
        let mut ldl = Ldl::new();
        for (side, seed) in [(3, 1), (5, 2), (5, 3), (3, 4)] {
            let (triplets, _) = grid(side, 20.0, seed);
            let (mut fresh, mut b) = (Ldl::new(), vec![1.0; triplets.size()]);
            let mut c = b.clone();
            assert_eq!(ldl.factor(&triplets, 0.0), fresh.factor(&triplets, 0.0));
            ldl.solve(&mut b);
            fresh.solve(&mut c);
            assert_eq!(b, c);
        }
    }

    #[test]
    fn an_elimination_kept_for_two_patterns_solves_both() {
        let (full, _) = grid(5, 20.0, 7);
        let mut without = Triplets::new(full.size());
        // The same without the couplings of far unknowns, and with one that the first lacks.
        for (&(i, j), value) in full.places.iter().zip(&full.values) {
            if i.abs_diff(j) < 8 {
                without.add(i as usize, j as usize, *value);
            }
        }
        without.add(full.size() - 1, 0, 0.5);
        let mut kept = Ldl::new();
        for round in 0..4 {
            let matrix = if round % 2 == 0 { &full } else { &without };
            let (mut fresh, mut b) = (Ldl::new(), vec![1.0; matrix.size()]);
            let mut c = b.clone();
            assert_eq!(kept.factor(matrix, 0.0), fresh.factor(matrix, 0.0));
            kept.solve(&mut b);
            fresh.solve(&mut c);
            // Another order rounds otherwise: the condition is below 10.
            assert!(b.iter().zip(&c).all(|(b, c)| (b - c).abs() < 1e-15), "{round}");
            assert_eq!(kept.joined, if round == 0 { 1 } else { 2 });
        }
    }

    #[test]
    fn singular_and_not_finite_matrices_are_refused_by_unknown() {
        let mut zero = Triplets::new(3);
        zero.add(0, 0, 1.0);
        zero.add(2, 2, 1.0);
        let refused = Ldl::new().factor(&zero, 0.0).unwrap_err();
        assert_eq!(refused.unknown, 1, "{refused}");
        zero.add(1, 1, f64::NAN);
        assert!(Ldl::new().factor(&zero, 0.0).is_err());
    }

    #[test]
    fn fixed_unknowns_keep_out_of_the_rest() {
        let (mut triplets, dense) = grid(3, 20.0, 5);
        let mut fixed = vec![false; triplets.size()];
        fixed[4] = true;
        triplets.fix(&fixed, 1.0);
        let mut ldl = Ldl::new();
        ldl.factor(&triplets, 0.0).unwrap();
        let mut b = vec![1.0; triplets.size()];
        b[4] = 0.0;
        ldl.solve(&mut b);
        let rest = (&dense * DVector::from_column_slice(&b)).map(|v| v - 1.0);
        assert_eq!(b[4], 0.0);
        assert!(rest.iter().enumerate().all(|(i, r)| i == 4 || r.abs() < 1e-13));
    }
}
