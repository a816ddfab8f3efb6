//! Dense parts of the elimination, column by column in memory.
//!
//! Small ones go by loops over whole columns, four at a time into two; large ones by the matrix product of `nalgebra`, which uses
//! the widest registers that the processor has.

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};

use super::share::share;

/// Columns eliminated together before the rest is brought up to date.
const BLOCK_COLUMNS: usize = 4;
/// Products with this many rows and columns, and this many terms, are worth the library's preparations.
const PACKED_FROM_SIDE: usize = 48;
const PACKED_FROM_DEPTH: usize = 12;
/// Columns of a triangle that are updated as one rectangle.
const STRIP_COLUMNS: usize = 48;
const NARROW_STRIP_COLUMNS: usize = 12;
/// Multiplications that are worth several threads, which take some tens of microseconds to begin.
const SHARED_FROM: usize = 8_000_000;
/// A pivot below this part of the diagonal entry that it comes from counts as zero: what is left is rounding.
// Some 45 times 2^-52: what cancellation of a diagonal entry may leave.
const ZERO_PIVOT: f64 = 1e-14;

/// A pivot vanished: column, pivot, diagonal entry.
pub(super) type Vanished = (usize, f64, f64);

/// Memory for products, and how many threads may share a large one: none counts as one.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    terms: Vec<f64>,
    pub(super) threads: usize,
}

/// Eliminates the first columns of a dense matrix of `size` rows, of which `panel` holds them: `L` below the diagonal and
/// the pivots on it. `diagonal` holds the matrix's own diagonal entries. How many pivots are negative: at `most` of them it ends.
pub(super) fn eliminate(
    panel: &mut [f64],
    size: usize,
    diagonal: &[f64],
    most: usize,
    scratch: &mut Scratch,
) -> Result<usize, Vanished> {
    halves(panel, size, diagonal, [0, diagonal.len()], most, scratch)
}

/// The columns from one to another: one half, what that takes from the other, the other half.
fn halves(
    panel: &mut [f64],
    size: usize,
    diagonal: &[f64],
    [from, to]: [usize; 2],
    most: usize,
    scratch: &mut Scratch,
) -> Result<usize, Vanished> {
    // By halves, so that most of the work is in products with many terms, whatever the width.
    if to - from <= BLOCK_COLUMNS {
        let mut negative = 0;
        for (k, own) in diagonal.iter().enumerate().take(to).skip(from) {
            negative += usize::from(column(panel, size, [k, to], *own).map_err(|pivot| (k, pivot, *own))?);
            if negative >= most {
                break;
            }
        }
        return Ok(negative);
    }
    // A multiple of the block, so that only the last block is narrower.
    let middle = from + (to - from).div_ceil(2 * BLOCK_COLUMNS) * BLOCK_COLUMNS;
    let before = halves(panel, size, diagonal, [from, middle], most, scratch)?;
    // The caller asks only whether there are so many: what is left need not be eliminated.
    if before >= most {
        return Ok(before);
    }
    let (done, rest) = panel.split_at_mut(middle * size);
    let factor = Factor {
        columns: &done[from * size..],
        size,
        skip: middle,
    };
    // The rest of the panel begins at row 0; only what lies at and below its diagonal counts.
    subtract(&factor, &mut rest[middle..], size, to - middle, scratch);
    Ok(before + halves(panel, size, diagonal, [middle, to], most - before, scratch)?)
}

/// One column: divided by its pivot, and taken from the columns up to `to`. True where the pivot is negative.
fn column(panel: &mut [f64], size: usize, [k, to]: [usize; 2], diagonal: f64) -> Result<bool, f64> {
    let (done, rest) = panel.split_at_mut((k + 1) * size);
    let own = &mut done[k * size + k..];
    let pivot = own[0];
    // A zero entry has a zero bound: equality counts as vanished too.
    if pivot.is_nan() || pivot.abs() <= ZERO_PIVOT * diagonal.abs() {
        return Err(pivot);
    }
    let own = &mut own[1..];
    for (c, other) in rest.chunks_exact_mut(size).take(to - k - 1).enumerate() {
        // The column is not divided yet: its entries still are those of `L` times the pivot.
        let by = own[c] / pivot;
        let below = &mut other[k + 1 + c..];
        below.iter_mut().zip(&own[c..]).for_each(|(y, l)| *y -= by * l);
    }
    own.iter_mut().for_each(|l| *l /= pivot);
    Ok(pivot < 0.0)
}

/// Columns of `L` with their pivots on the diagonal, seen from row `skip` on.
pub(super) struct Factor<'a> {
    pub(super) columns: &'a [f64],
    pub(super) size: usize,
    pub(super) skip: usize,
}

impl Factor<'_> {
    fn depth(&self) -> usize {
        self.columns.len() / self.size
    }

    /// The pivot of a column: the last columns before row `skip` in a panel, the first ones of a front.
    fn pivot(&self, p: usize) -> f64 {
        let row = self.skip - self.depth() + p;
        self.columns[p * self.size + row]
    }

    fn rows(&self, p: usize, from: usize) -> &[f64] {
        &self.columns[p * self.size + self.skip + from..(p + 1) * self.size]
    }
}

/// `C -= L D L^T` on and below the diagonal of a matrix of `count` columns, `stride` entries apart, as tall as `L` is from
/// `skip` on.
pub(super) fn subtract(factor: &Factor<'_>, c: &mut [f64], stride: usize, count: usize, scratch: &mut Scratch) {
    let (height, depth) = (factor.size - factor.skip, factor.depth());
    let mut strips = Vec::new();
    let mut from = 0;
    // The library packs both factors first, which few terms do not repay.
    if depth >= PACKED_FROM_DEPTH {
        while height - from >= PACKED_FROM_SIDE && count - from >= NARROW_STRIP_COLUMNS {
            let width = STRIP_COLUMNS.min(count - from);
            strips.push([from, width]);
            from += width;
        }
    }
    if scratch.threads > 1 && height * count * depth >= SHARED_FROM {
        shared(factor, c, stride, &strips, scratch.threads);
    } else {
        for [from, width] in strips {
            strip(
                factor,
                &mut c[from * (stride + 1)..],
                stride,
                [from, width],
                &mut scratch.terms,
            );
        }
    }
    let mut j = from;
    // Two columns at a time: each entry of `L` that is read serves both.
    while j + 1 < count {
        let (one, two) = c[j * stride..].split_at_mut(stride);
        pair(factor, &mut one[j..height], &mut two[j..height], j);
        j += 2;
    }
    if j < count {
        single(factor, &mut c[j * stride + j..j * stride + height], j, 0);
    }
}

/// Strips by several threads: each has columns of its own, so that the bits are those of one.
fn shared(factor: &Factor<'_>, mut c: &mut [f64], stride: usize, strips: &[[usize; 2]], threads: usize) {
    let mut jobs = Vec::new();
    for &[from, width] in strips {
        // The last column may end with its last row.
        let end = (width * stride).min(c.len());
        let (own, rest) = std::mem::take(&mut c).split_at_mut(end);
        c = rest;
        jobs.push((&mut own[from..], [from, width]));
    }
    share(jobs, threads, |(columns, strip_of)| {
        strip(factor, columns, stride, strip_of, &mut Vec::new());
    });
}

/// So many columns from one on by one product; entries above the diagonal are spoilt.
fn strip(factor: &Factor<'_>, c: &mut [f64], stride: usize, [from, width]: [usize; 2], terms: &mut Vec<f64>) {
    let (height, depth) = (factor.size - factor.skip - from, factor.depth());
    terms.clear();
    for p in 0..depth {
        let pivot = factor.pivot(p);
        // `D L^T` is formed once: the library's product knows no diagonal between its factors.
        terms.extend(factor.rows(p, from)[..width].iter().map(|l| l * pivot));
    }
    let (one, size) = (Dyn(1), Dyn(factor.size));
    let (tall, wide) = (Dyn(height), Dyn(width));
    let lower = &factor.columns[factor.skip + from..];
    let a = DMatrixView::from_slice_with_strides_generic(lower, tall, Dyn(depth), one, size);
    let b = DMatrixView::from_slice_with_strides_generic(terms, Dyn(depth), wide, wide, one);
    let mut c = DMatrixViewMut::from_slice_with_strides_generic(c, tall, wide, one, Dyn(stride));
    // A full rectangle: what it wastes above the diagonal is little in a narrow strip.
    c.gemm(-1.0, &a, &b, 1.0);
}

/// Two neighbouring columns, the first from its diagonal on, the second from the row of that.
fn pair(factor: &Factor<'_>, one: &mut [f64], two: &mut [f64], j: usize) {
    let (depth, mut p) = (factor.depth(), 0);
    while p + 4 <= depth {
        terms::<4>(factor, one, two, [j, p]);
        p += 4;
    }
    if p + 2 <= depth {
        terms::<2>(factor, one, two, [j, p]);
        p += 2;
    }
    if p < depth {
        terms::<1>(factor, one, two, [j, p]);
    }
}

/// So many columns of `L`, from `p` on, taken from both.
#[inline]
fn terms<const N: usize>(factor: &Factor<'_>, one: &mut [f64], two: &mut [f64], [j, p]: [usize; 2]) {
    let n = one.len();
    let l: [&[f64]; N] = std::array::from_fn(|q| &factor.rows(p + q, j)[..n]);
    let by: [f64; N] = std::array::from_fn(|q| l[q][0] * factor.pivot(p + q));
    let and: [f64; N] = std::array::from_fn(|q| l[q][1] * factor.pivot(p + q));
    let two = &mut two[..n];
    for i in 0..n {
        let sum = |by: &[f64; N]| {
            let each: [f64; N] = std::array::from_fn(|q| by[q] * l[q][i]);
            // Two by two: neither waits for the other.
            each.chunks(2).map(|c| c.iter().sum::<f64>()).sum::<f64>()
        };
        one[i] -= sum(&by);
        two[i] -= sum(&and);
    }
}

/// One column, from its diagonal on, by the columns of `L` from `p` on.
fn single(factor: &Factor<'_>, column: &mut [f64], j: usize, p: usize) {
    for p in p..factor.depth() {
        let l = factor.rows(p, j);
        let by = l[0] * factor.pivot(p);
        column.iter_mut().zip(l).for_each(|(y, l)| *y -= by * l);
    }
}
