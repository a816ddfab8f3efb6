//! What columns of `L` take from a dense symmetric matrix.
//!
//! Small products go by loops over whole columns, four at a time into two; large ones by the matrix product of `nalgebra`, which uses
//! the widest registers that the processor has.

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};

use super::number::Number;
use super::share::share;

/// Products with this many rows and columns, and this many terms, are worth the library's preparations.
const PACKED_FROM_SIDE: usize = 48;
const PACKED_FROM_DEPTH: usize = 12;
/// Columns that are updated together. The library packs what is below them once for each strip.
const STRIP_COLUMNS: usize = 256;
const NARROW_STRIP_COLUMNS: usize = 12;
/// Columns of a triangle that are updated as one rectangle.
const TRIANGLE_COLUMNS: usize = 48;
/// Multiplications that are worth several threads, which take some tens of microseconds to begin.
const SHARED_FROM: usize = 8_000_000;

/// Memory for products, and how many threads may share a large one: none counts as one.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch<T = f64> {
    terms: Vec<T>,
    pub(super) threads: usize,
}

/// Columns of `L` with their pivots on the diagonal, seen from row `skip` on.
pub(super) struct Factor<'a, T = f64> {
    pub(super) columns: &'a [T],
    pub(super) size: usize,
    pub(super) skip: usize,
}

impl<T: Number> Factor<'_, T> {
    fn depth(&self) -> usize {
        self.columns.len() / self.size
    }

    /// The pivot of a column: the last columns before row `skip` in a panel, the first ones of a front.
    fn pivot(&self, p: usize) -> T {
        let row = self.skip - self.depth() + p;
        self.columns[p * self.size + row]
    }

    fn rows(&self, p: usize, from: usize) -> &[T] {
        &self.columns[p * self.size + self.skip + from..(p + 1) * self.size]
    }
}

/// `C -= L D L^T` on and below the diagonal of a matrix of `count` columns, `stride` entries apart, as tall as `L` is from
/// `skip` on. What lies above the diagonal is spoilt.
pub(super) fn subtract<T: Number>(
    factor: &Factor<'_, T>,
    c: &mut [T],
    stride: usize,
    count: usize,
    scratch: &mut Scratch<T>,
) {
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
    // Threads cost more to hand out than a small product takes.
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
    // An odd one is left.
    if j < count {
        single(factor, &mut c[j * stride + j..j * stride + height], j, 0);
    }
}

/// Strips by several threads: each has columns of its own, so that the bits are those of one.
fn shared<T: Number>(factor: &Factor<'_, T>, mut c: &mut [T], stride: usize, strips: &[[usize; 2]], threads: usize) {
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

/// So many columns from one on; entries above the diagonal are spoilt.
fn strip<T: Number>(factor: &Factor<'_, T>, c: &mut [T], stride: usize, [from, width]: [usize; 2], terms: &mut Vec<T>) {
    terms.clear();
    for p in 0..factor.depth() {
        let pivot = factor.pivot(p);
        // `D L^T` is formed once: the library's product knows no diagonal between its factors.
        terms.extend(factor.rows(p, from)[..width].iter().map(|l| *l * pivot));
    }
    // The triangle by narrow steps, each with what is below it in the triangle, as a rectangle wastes what is above the diagonal.
    let height = factor.size - factor.skip - from;
    let steps = if width > TRIANGLE_COLUMNS { width } else { 0 };
    for at in (0..steps).step_by(TRIANGLE_COLUMNS) {
        let columns = [at, TRIANGLE_COLUMNS.min(width - at)];
        rectangle(factor, c, stride, [from, width], columns, [at, width - at], terms);
    }
    // All of what is below the triangle at once, or a narrow strip from its diagonal on.
    rectangle(
        factor,
        c,
        stride,
        [from, width],
        [0, width],
        [steps, height - steps],
        terms,
    );
}

/// Some columns and rows (first, count) of a strip by one product.
fn rectangle<T: Number>(
    factor: &Factor<'_, T>,
    c: &mut [T],
    stride: usize,
    [from, width]: [usize; 2],
    [column, columns]: [usize; 2],
    [row, rows]: [usize; 2],
    terms: &[T],
) {
    if rows == 0 {
        return;
    }
    let (one, size, depth) = (Dyn(1), Dyn(factor.size), Dyn(factor.depth()));
    let (tall, wide) = (Dyn(rows), Dyn(columns));
    let lower = &factor.columns[factor.skip + from + row..];
    let a = DMatrixView::from_slice_with_strides_generic(lower, tall, depth, one, size);
    let b = DMatrixView::from_slice_with_strides_generic(&terms[column..], depth, wide, Dyn(width), one);
    let own = &mut c[column * stride + row..];
    let c = DMatrixViewMut::from_slice_with_strides_generic(own, tall, wide, one, Dyn(stride));
    T::subtract_product(c, &a, &b);
}

/// Two neighbouring columns, the first from its diagonal on, the second from the row of that.
fn pair<T: Number>(factor: &Factor<'_, T>, one: &mut [T], two: &mut [T], j: usize) {
    let (depth, mut p) = (factor.depth(), 0);
    while p + 4 <= depth {
        terms::<T, 4>(factor, one, two, [j, p]);
        p += 4;
    }
    if p + 2 <= depth {
        terms::<T, 2>(factor, one, two, [j, p]);
        p += 2;
    }
    if p < depth {
        terms::<T, 1>(factor, one, two, [j, p]);
    }
}

/// So many columns of `L`, from `p` on, taken from both.
#[inline]
fn terms<T: Number, const N: usize>(factor: &Factor<'_, T>, one: &mut [T], two: &mut [T], [j, p]: [usize; 2]) {
    let n = one.len();
    let l: [&[T]; N] = std::array::from_fn(|q| &factor.rows(p + q, j)[..n]);
    let by: [T; N] = std::array::from_fn(|q| l[q][0] * factor.pivot(p + q));
    let and: [T; N] = std::array::from_fn(|q| l[q][1] * factor.pivot(p + q));
    let two = &mut two[..n];
    for i in 0..n {
        let sum = |by: &[T; N]| {
            let each: [T; N] = std::array::from_fn(|q| by[q] * l[q][i]);
            // Two by two: neither waits for the other.
            each.chunks(2).map(|c| c.iter().copied().sum::<T>()).sum::<T>()
        };
        one[i] -= sum(&by);
        two[i] -= sum(&and);
    }
}

/// One column, from its diagonal on, by the columns of `L` from `p` on.
fn single<T: Number>(factor: &Factor<'_, T>, column: &mut [T], j: usize, p: usize) {
    for p in p..factor.depth() {
        let l = factor.rows(p, j);
        let by = l[0] * factor.pivot(p);
        column.iter_mut().zip(l).for_each(|(y, l)| *y -= by * *l);
    }
}
