//! Where the paper may end: its edge, blurred, looks like a shift of the discs next to it.

use nalgebra::{Matrix2, Vector2};

/// Paper is taken for granted up to so many steps beyond the outer discs' centres.
const PAPER_STEPS: f64 = 1.0;
/// From so many deviations of the blur an edge leaves 0.13 % of its contrast.
pub(crate) const CLEAR: f64 = 3.0;

/// The outer lines of some discs.
pub(crate) struct Border {
    low: [i32; 2],
    high: [i32; 2],
}

/// From the least to the most column, and row, off a disc's centre, in steps of the grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range(Matrix2<f64>);

impl Border {
    pub(crate) fn of(cells: impl Iterator<Item = [i32; 2]>) -> Self {
        let start = Self {
            low: [i32::MAX; 2],
            high: [i32::MIN; 2],
        };
        cells.fold(start, |b, c| Self {
            low: [0, 1].map(|i| b.low[i].min(c[i])),
            high: [0, 1].map(|i| b.high[i].max(c[i])),
        })
    }

    /// How far from a cell pixels may be: `most` steps, and not nearer than `clear` px to the paper's end. `pitch`
    /// are the pixels for a step there.
    pub(crate) fn range(&self, cell: [i32; 2], pitch: &Matrix2<f64>, clear: f64, most: f64) -> Range {
        let mut range = Matrix2::zeros();
        for i in 0..2 {
            // Across a line of the grid a step is as long as the cell's area is beside a step along the line.
            let across = pitch.determinant().abs() / pitch.column(1 - i).norm();
            // Negative where more than a step is to be kept clear: then part of the outer discs' own pixels is given up
            // as well.
            let edge = PAPER_STEPS - clear / across;
            range[(i, 0)] = (f64::from(self.low[i] - cell[i]) - edge).max(-most);
            range[(i, 1)] = (f64::from(self.high[i] - cell[i]) + edge).min(most);
        }
        Range(range)
    }
}

impl Range {
    pub(crate) fn holds(&self, off: &Vector2<f64>) -> bool {
        (0..2).all(|i| self.0[(i, 0)] <= off[i] && off[i] <= self.0[(i, 1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows 5 px apart, columns 20 px: a blur of 2 px keeps 6 px from the paper's end, which is 5 px beyond the last row.
    #[test]
    fn pixels_that_the_end_of_the_paper_reaches_are_left_out() {
        let border = Border::of([[0, 0], [9, 7]].into_iter());
        let pitch = Matrix2::new(20.0, 0.0, 0.0, 5.0);
        let range = |cell| border.range(cell, &pitch, 6.0, 0.5);
        let last = range([9, 7]);
        assert!(last.holds(&Vector2::new(0.5, -0.21)));
        assert!(!last.holds(&Vector2::new(0.5, -0.19)));
        assert!(range([9, 6]).holds(&Vector2::new(-0.5, 0.5)));
        assert!(!range([4, 4]).holds(&Vector2::new(0.51, 0.0)));
        // Columns that run slantwise lie 0.98 px from one another, however long a step along a row is: 0.5 px are 0.51 steps.
        let slant = Matrix2::new(5.0, 100.0, 0.0, 20.0);
        let first = border.range([0, 3], &slant, 0.5, 0.75);
        assert!(first.holds(&Vector2::new(-0.48, 0.0)));
        assert!(!first.holds(&Vector2::new(-0.50, 0.0)));
    }
}
