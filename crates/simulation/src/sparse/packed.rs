//! A factor stored for solutions: what a substitution reads lies in one piece, in the order in which it is read.
//!
//! A solution reads every entry of `L` twice and does two flops with each: memory is what it waits for. Read column by column as it was
//! eliminated, a factor comes at a third of the rate, as its columns are short and begin anew every time. Here blocks of columns lie
//! row by row, one block after the other. Sums are in double precision, whatever entries are stored in.

use std::ops::Range;

use super::kept::Kept;
use super::number::Number;
use super::symbolic::{Front, Symbolic};

/// Columns of a block: as many as fit, the widest first.
const WIDTHS: [usize; 4] = [8, 4, 2, 1];

/// Columns of a front: the first, and how many.
fn blocks(width: usize) -> impl DoubleEndedIterator<Item = (usize, usize)> {
    let [widest, narrower @ ..] = WIDTHS;
    let whole = width / widest;
    let wide = (0..whole).map(move |b| (b * widest, widest));
    // What is left takes each of the others once at the most, as its bits say.
    let rest = narrower.into_iter().filter(move |n| width & n != 0);
    wide.chain(rest.map(move |n| (width & !(2 * n - 1), n)))
}

/// Entries of a front.
pub(super) fn length(front: &Front) -> usize {
    blocks(front.width).map(|(k, n)| n * (front.size() - k)).sum()
}

/// Takes up the columns of a front, as they were eliminated.
// Nothing is cleared: every entry is written, those at and above the diagonal as zeros.
pub(super) fn keep<E: Number, T: Number>(front: &Front, panel: &[E], mut entries: &mut [T]) {
    let size = front.size();
    for (k, n) in blocks(front.width) {
        let columns = &panel[k * size..(k + n) * size];
        let (block, rest) = entries.split_at_mut(n * (size - k));
        entries = rest;
        // The number of columns is a constant in each, so that loops over them can be unrolled.
        match n {
            8 => interleave::<E, T, 8>(columns, k, block),
            4 => interleave::<E, T, 4>(columns, k, block),
            2 => interleave::<E, T, 2>(columns, k, block),
            _ => interleave::<E, T, 1>(columns, k, block),
        }
    }
}

impl<T: Number> Kept<T> {
    /// `L x = b`, then `D x = b`, of some fronts.
    pub(super) fn forward(&self, symbolic: &Symbolic, fronts: Range<usize>, x: &mut [f64]) {
        let mut all = Vec::new();
        for k in fronts {
            let front = &symbolic.fronts[k];
            let own = front.first..front.first + front.width;
            // A right side with few entries fills their way up only.
            if x[own.clone()].iter().all(|x| *x == 0.0) {
                continue;
            }
            all.clear();
            all.extend_from_slice(&x[own.clone()]);
            all.resize(front.size(), 0.0);
            let mut start = self.starts[k];
            for (k, n) in blocks(front.width) {
                let block = &self.entries[start..start + n * (front.size() - k)];
                start += block.len();
                match n {
                    8 => take_off::<T, 8>(block, &mut all[k..]),
                    4 => take_off::<T, 4>(block, &mut all[k..]),
                    2 => take_off::<T, 2>(block, &mut all[k..]),
                    _ => take_off::<T, 1>(block, &mut all[k..]),
                }
            }
            // Pivots divide only now: rows below take off products with the solution for `L` alone.
            let (values, below) = all.split_at(front.width);
            let divided = values.iter().zip(&self.pivots[own.clone()]);
            x[own].iter_mut().zip(divided).for_each(|(x, (v, d))| *x = v / d);
            // Rows below are scattered: each is met once for the whole front, not once for each column.
            let rows = symbolic.below(front).iter();
            rows.zip(below).for_each(|(row, by)| x[*row as usize] += by);
        }
    }

    /// `L^T x = b` of some fronts.
    pub(super) fn back(&self, symbolic: &Symbolic, fronts: Range<usize>, x: &mut [f64]) {
        let mut all = Vec::new();
        for k in fronts.rev() {
            let front: &Front = &symbolic.fronts[k];
            let own = front.first..front.first + front.width;
            all.clear();
            all.extend_from_slice(&x[own.clone()]);
            // Values below are solved for already, as their fronts are eliminated after this one.
            all.extend(symbolic.below(front).iter().map(|row| x[*row as usize]));
            let mut end = self.starts[k + 1];
            for (k, n) in blocks(front.width).rev() {
                let block = &self.entries[end - n * (front.size() - k)..end];
                end -= block.len();
                match n {
                    8 => put_in::<T, 8>(block, &mut all[k..]),
                    4 => put_in::<T, 4>(block, &mut all[k..]),
                    2 => put_in::<T, 2>(block, &mut all[k..]),
                    _ => put_in::<T, 1>(block, &mut all[k..]),
                }
            }
            x[own].copy_from_slice(&all[..front.width]);
        }
    }
}

/// `N` columns, the first of them column `k` of its front, row by row from row `k` on.
fn interleave<E: Number, T: Number, const N: usize>(columns: &[E], k: usize, block: &mut [T]) {
    let size = columns.len() / N;
    let columns: [&[E]; N] = std::array::from_fn(|c| &columns[c * size + k..(c + 1) * size]);
    for (i, row) in block.as_chunks_mut::<N>().0.iter_mut().enumerate() {
        for (c, l) in row.iter_mut().enumerate() {
            *l = if i > c {
                T::rounded(columns[c][i].value())
            } else {
                T::default()
            };
        }
    }
}

/// Solves for the first `N` of `y` and takes from the rest what they add to it.
fn take_off<T: Number, const N: usize>(block: &[T], y: &mut [f64]) {
    let (rows, _) = block.as_chunks::<N>();
    let (own, below) = y.split_at_mut(N);
    let mut values = [0.0; N];
    for c in 0..N {
        values[c] = own[c];
        (c + 1..N).for_each(|i| own[i] -= rows[i][c].value() * values[c]);
    }
    for (l, y) in rows[N..].iter().zip(below) {
        // Even and odd ones apart: two sums in one register.
        let mut sums = [0.0; 2];
        (0..N).for_each(|c| sums[c % 2] += l[c].value() * values[c]);
        *y -= sums[0] + sums[1];
    }
}

/// Takes from the first `N` of `y` the products of their columns with the rest, and solves for them.
fn put_in<T: Number, const N: usize>(block: &[T], y: &mut [f64]) {
    let (rows, _) = block.as_chunks::<N>();
    let (own, below) = y.split_at_mut(N);
    // Every other row apart, so that neither sum waits for the other.
    let mut sums = [[0.0; N]; 2];
    // From the last row on, as fronts and blocks come too: memory is read in one direction.
    let (pairs, last) = rows[N..].as_chunks::<2>();
    let (y, y_last) = below.as_chunks::<2>();
    for (l, y) in last.iter().zip(y_last) {
        (0..N).for_each(|c| sums[0][c] += l[c].value() * y);
    }
    for (l, y) in pairs.iter().zip(y).rev() {
        (0..N).for_each(|c| sums[1][c] += l[1][c].value() * y[1]);
        (0..N).for_each(|c| sums[0][c] += l[0][c].value() * y[0]);
    }
    // Within the block each value needs those after it: these products cannot be summed ahead.
    for c in (0..N).rev() {
        let near: f64 = (c + 1..N).map(|i| rows[i][c].value() * own[i]).sum();
        own[c] -= sums[0][c] + sums[1][c] + near;
    }
}
