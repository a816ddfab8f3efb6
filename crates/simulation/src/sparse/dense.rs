//! `L D L^T` of a small dense matrix by the kernels of a front: whole, or of its first unknowns only.

use nalgebra::DMatrix;

use super::front::{Factor, Scratch, eliminate, subtract};

/// A dense factor of the first unknowns, and what their elimination leaves on the others.
#[derive(Debug, Clone, Default)]
pub(crate) struct Dense {
    size: usize,
    eliminated: usize,
    /// Column by column: `L` below the diagonal, the pivots on it; of columns that are not eliminated what is left.
    factor: Vec<f64>,
    diagonal: Vec<f64>,
    scratch: Scratch,
}

impl Dense {
    /// Factors a symmetric matrix, of which the lower triangle counts. False where it is not positive definite: then there is
    /// nothing to solve with.
    pub(crate) fn factor(&mut self, matrix: &DMatrix<f64>) -> bool {
        self.eliminate(matrix, matrix.nrows())
    }

    /// Eliminates the first unknowns only. False where they are not positive definite.
    pub(crate) fn eliminate(&mut self, matrix: &DMatrix<f64>, count: usize) -> bool {
        (self.size, self.eliminated) = (matrix.nrows(), count);
        self.factor.clear();
        self.factor.extend_from_slice(matrix.as_slice());
        self.diagonal.clear();
        self.diagonal.extend(matrix.diagonal().iter().take(count));
        // As in a front: the columns to eliminate are one panel, the others take what it leaves.
        let (panel, rest) = self.factor.split_at_mut(count * self.size);
        if eliminate(panel, self.size, &self.diagonal, 1, &mut self.scratch) != Ok(0) {
            return false;
        }
        // Within the panel columns were brought up to date as they went; those beside it at once, by a product.
        if count > 0 && count < self.size {
            let done = Factor {
                columns: panel,
                size: self.size,
                skip: count,
            };
            subtract(
                &done,
                &mut rest[count..],
                self.size,
                self.size - count,
                &mut self.scratch,
            );
        }
        true
    }

    /// What is left on the unknowns that are not eliminated: their Schur complement, whole.
    pub(crate) fn rest(&self, rest: &mut DMatrix<f64>) {
        let (skip, count) = (self.eliminated, self.size - self.eliminated);
        if rest.nrows() != count {
            *rest = DMatrix::zeros(count, count);
        }
        for (column, mut to) in self.factor[skip * self.size..]
            .chunks_exact(self.size.max(1))
            .zip(rest.column_iter_mut())
        {
            to.as_mut_slice().copy_from_slice(&column[skip..]);
        }
        rest.fill_upper_triangle_with_lower_triangle();
    }

    fn columns(&self) -> impl DoubleEndedIterator<Item = (usize, &[f64])> + ExactSizeIterator {
        self.factor
            .chunks_exact(self.size.max(1))
            .enumerate()
            .take(self.eliminated)
    }

    /// The first half of a solution: right sides of what is not eliminated are then those of [`Self::rest`].
    pub(crate) fn forward(&self, x: &mut [f64]) {
        for (k, column) in self.columns() {
            let (known, below) = x.split_at_mut(k + 1);
            below
                .iter_mut()
                .zip(&column[k + 1..])
                .for_each(|(x, l)| *x -= l * known[k]);
        }
    }

    /// The second half, with what is not eliminated known.
    pub(crate) fn back(&self, x: &mut [f64]) {
        for (k, column) in self.columns().rev() {
            let (own, below) = x.split_at_mut(k + 1);
            own[k] = own[k] / column[k] - dot(&column[k + 1..], below);
        }
    }

    /// `x` becomes the solution, where all is eliminated.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        self.forward(x);
        self.back(x);
    }
}

/// Four sums, so that none waits for the one before.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let sums = a
        .zip(b)
        .fold([0.0; 4], |s, (a, b)| std::array::from_fn(|k| s[k] + a[k] * b[k]));
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dense_solution_has_no_residual_whole_or_by_what_is_left() {
        let size = 150;
        // Hilbert's matrix and the identity: definite, with a condition of some 3.
        let matrix = DMatrix::from_fn(size, size, |i, j| {
            1.0 / (1 + i + j) as f64 + f64::from(u8::from(i == j))
        });
        let wanted: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
        let right = &matrix * DMatrix::from_column_slice(size, 1, &wanted);
        let (mut first, mut last, mut rest) = (Dense::default(), Dense::default(), DMatrix::zeros(0, 0));
        for count in [0, 1, 70, 149, 150] {
            assert!(first.eliminate(&matrix, count));
            first.rest(&mut rest);
            assert!(last.factor(&rest));
            let mut x = right.as_slice().to_vec();
            first.forward(&mut x);
            last.solve(&mut x[count..]);
            first.back(&mut x);
            // Sums of 150 terms of size 1 round to some 2e-14.
            assert!(x.iter().zip(&wanted).all(|(x, w)| (x - w).abs() < 2e-13), "{count}");
        }
        assert!(!first.factor(&-matrix));
    }
}
