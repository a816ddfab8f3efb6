//! Forward and back substitution by fronts, blocks of columns at a time.
//!
//! A solution reads every entry of the factor twice and does two flops with each: it can be no faster than memory. So entries
//! may be stored in single precision ([`Stored`]); sums are in double.

use std::ops::Range;

use super::symbolic::Symbolic;

/// Columns taken together: one pass over what is below them.
const COLUMNS: usize = 4;
/// Sums that go on side by side along a column.
const LANES: usize = 4;

/// An entry of a factor as it is stored.
pub(super) trait Stored: Copy {
    fn value(self) -> f64;
}

impl Stored for f64 {
    #[inline]
    fn value(self) -> f64 {
        self
    }
}

impl Stored for f32 {
    #[inline]
    fn value(self) -> f64 {
        f64::from(self)
    }
}

/// The columns of `L` of all fronts, and the pivots in the order of elimination.
pub(super) struct Stores<'a, T> {
    pub(super) symbolic: &'a Symbolic,
    pub(super) columns: &'a [T],
    pub(super) pivots: &'a [f64],
}

impl<T: Stored> Stores<'_, T> {
    /// `L x = b`, then `D x = b`, of some fronts.
    pub(super) fn forward(&self, fronts: Range<usize>, x: &mut [f64]) {
        let mut below = Vec::new();
        for front in &self.symbolic.fronts[fronts] {
            let (panel, size, width) = (&self.columns[front.panel()], front.size(), front.width);
            below.clear();
            below.resize(front.height, 0.0);
            let own = &mut x[front.first..front.first + width];
            for (k, block) in panel.chunks(COLUMNS * size).enumerate() {
                let k = k * COLUMNS;
                let (done, rest) = own.split_at_mut((k + COLUMNS).min(width));
                let values = &mut done[k..];
                within(block, size, k, values);
                let after = k + values.len();
                // Both in the order of the columns: the same bits as one column at a time.
                if let Ok(values) = <&[f64; COLUMNS]>::try_from(&*values) {
                    add(&columns(block, size, after..width), &values.map(|v| -v), rest);
                    add(&columns(block, size, width..size), values, &mut below);
                } else {
                    for (column, value) in block.chunks_exact(size).zip(&*values) {
                        add(&[&column[width..]], &[*value], &mut below);
                    }
                }
            }
            own.iter_mut()
                .zip(&self.pivots[front.first..])
                .for_each(|(x, pivot)| *x /= pivot);
            let rows = &self.symbolic.rows[front.rows..front.rows + front.height];
            rows.iter().zip(&below).for_each(|(row, by)| x[*row as usize] -= by);
        }
    }

    /// `L^T x = b` of some fronts, blocks of columns at a time.
    pub(super) fn back(&self, fronts: Range<usize>, x: &mut [f64]) {
        let mut all = Vec::new();
        for front in self.symbolic.fronts[fronts].iter().rev() {
            let (panel, size, width) = (&self.columns[front.panel()], front.size(), front.width);
            self.gather(front, x, &mut all);
            let mut end = width;
            // The last columns that fill no block come first.
            while end > 0 {
                let from = (end - 1) / COLUMNS * COLUMNS;
                let block = &panel[from * size..end * size];
                if end - from == COLUMNS {
                    let sums = products(&columns(block, size, end..size), &all[end..]);
                    (0..COLUMNS).for_each(|c| all[from + c] -= sums[c]);
                    column_by_column(block, size, from, &mut all[..end]);
                } else {
                    column_by_column(block, size, from, &mut all);
                }
                end = from;
            }
            x[front.first..front.first + width].copy_from_slice(&all[..width]);
        }
    }

    /// The same, column by column: with the rounding that it always had.
    pub(super) fn back_by_column(&self, x: &mut [f64]) {
        let mut all = Vec::new();
        for front in self.symbolic.fronts.iter().rev() {
            self.gather(front, x, &mut all);
            column_by_column(&self.columns[front.panel()], front.size(), 0, &mut all);
            x[front.first..front.first + front.width].copy_from_slice(&all[..front.width]);
        }
    }

    /// The unknowns of a front's rows.
    fn gather(&self, front: &super::symbolic::Front, x: &[f64], all: &mut Vec<f64>) {
        let rows = &self.symbolic.rows[front.rows..front.rows + front.height];
        all.clear();
        all.extend_from_slice(&x[front.first..front.first + front.width]);
        all.extend(rows.iter().map(|row| x[*row as usize]));
    }
}

/// Some rows of each column of a block.
#[inline]
fn columns<T, const N: usize>(block: &[T], size: usize, rows: Range<usize>) -> [&[T]; N] {
    std::array::from_fn(|c| &block[c * size + rows.start..c * size + rows.end])
}

/// `L x = b` of the columns of a block among themselves, whose first is the front's column `k`.
fn within<T: Stored>(block: &[T], size: usize, k: usize, values: &mut [f64]) {
    for (c, column) in block.chunks_exact(size).enumerate() {
        let value = values[c];
        let below = column[k + c + 1..].iter();
        values[c + 1..]
            .iter_mut()
            .zip(below)
            .for_each(|(x, l)| *x -= l.value() * value);
    }
}

/// Adds multiples of columns to `y`, in their order.
#[inline]
fn add<T: Stored, const N: usize>(columns: &[&[T]; N], by: &[f64; N], y: &mut [f64]) {
    let n = y.len();
    let columns: [&[T]; N] = std::array::from_fn(|c| &columns[c][..n]);
    for i in 0..n {
        y[i] = (0..N).fold(y[i], |sum, c| sum + columns[c][i].value() * by[c]);
    }
}

/// The products of columns with `x`.
#[inline]
fn products<T: Stored>(columns: &[&[T]; COLUMNS], x: &[f64]) -> [f64; COLUMNS] {
    let n = x.len();
    let columns: [&[T]; COLUMNS] = std::array::from_fn(|c| &columns[c][..n]);
    let mut sums = [[0.0; LANES]; COLUMNS];
    let (x, last) = x.as_chunks::<LANES>();
    let chunks = columns.map(|c| c.as_chunks::<LANES>().0);
    for (i, x) in x.iter().enumerate() {
        for (sum, column) in sums.iter_mut().zip(&chunks) {
            (0..LANES).for_each(|k| sum[k] += column[i][k].value() * x[k]);
        }
    }
    let mut totals = sums.map(|s| (s[0] + s[1]) + (s[2] + s[3]));
    for (i, x) in (LANES * x.len()..n).zip(last) {
        (0..COLUMNS).for_each(|c| totals[c] += columns[c][i].value() * x);
    }
    totals
}

/// `L^T x = b` of some columns, the first of them column `first` of its front; `all` ends with the last row that counts.
fn column_by_column<T: Stored>(columns: &[T], size: usize, first: usize, all: &mut [f64]) {
    // Backwards: a column needs those after it.
    for (c, column) in columns.chunks_exact(size).enumerate().rev() {
        let k = first + c;
        let below = column[k + 1..all.len()].iter().zip(&all[k + 1..]);
        let sum: f64 = below.map(|(l, x)| l.value() * x).sum();
        all[k] -= sum;
    }
}
