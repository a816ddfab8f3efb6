//! Sums of normal equations.

use super::{Matrix8, UNKNOWNS, Vector8};

/// Sums of normal equations: the upper half of the matrix by rows, and the right side.
pub(super) struct Sums {
    upper: [f64; 36],
    slope: [f64; UNKNOWNS],
}

impl Sums {
    pub(super) fn new() -> Self {
        Self {
            upper: [0.0; 36],
            slope: [0.0; UNKNOWNS],
        }
    }

    #[inline]
    pub(super) fn add(&mut self, j: &Vector8, s: f64, weight: f64) {
        let mut place = 0;
        for row in 0..UNKNOWNS {
            let wj = weight * j[row];
            self.slope[row] += wj * s;
            for column in row..UNKNOWNS {
                self.upper[place] += wj * j[column];
                place += 1;
            }
        }
    }

    pub(super) fn whole(&self) -> (Matrix8, Vector8) {
        let mut matrix = Matrix8::zeros();
        let mut place = 0;
        for row in 0..UNKNOWNS {
            for column in row..UNKNOWNS {
                matrix[(row, column)] = self.upper[place];
                matrix[(column, row)] = self.upper[place];
                place += 1;
            }
        }
        (matrix, Vector8::from(self.slope))
    }
}
