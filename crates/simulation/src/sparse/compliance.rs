//! What unit forces on a few combinations of unknowns move of one another: `B A^-1 B^T`, by the part of a factor that they reach.
//!
//! A sparse right side fills only the unknowns on its way to the top of the elimination tree (Gilbert and Peierls 1988); combinations that lie close to one
//! another share most of it. So all of them go down together, front by front, as a dense matrix: `X = L^-1 B^T`, and `X^T D^-1 X` is the answer.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, Dyn};

use super::Ldl;
use super::symbolic::{Front, Symbolic};

/// Columns of a front that are solved one by one.
const NARROW: usize = 8;
/// Columns of the product that are made at once: entries above the diagonal are spent in vain.
const STRIP: usize = 48;

/// Combinations of unknowns: entries `(unknown, weight)` of each, one after the other.
#[derive(Debug, Clone, Default)]
pub(crate) struct Combinations {
    ends: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Combinations {
    /// Adds one.
    pub(crate) fn push(&mut self, entries: impl Iterator<Item = (u32, f64)>) {
        self.entries.extend(entries);
        self.ends.push(self.entries.len());
    }

    /// How many.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    fn each(&self) -> impl Iterator<Item = &[(u32, f64)]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(start, end)| &self.entries[*start..*end])
    }
}

/// The part of an elimination that right sides with some entries fill.
struct Reached {
    /// Fronts, children before parents, and where the unknowns of each begin here.
    fronts: Vec<(usize, usize)>,
    /// The same of every front; of no meaning for those that are not reached.
    starts: Vec<usize>,
    /// How many unknowns.
    size: usize,
}

impl Reached {
    fn new(symbolic: &Symbolic, combinations: &Combinations) -> Self {
        let count = symbolic.fronts.len();
        let mut reached = vec![false; count];
        for (unknown, _) in &combinations.entries {
            reached[symbolic.front_at(symbolic.place(*unknown))] = true;
        }
        let mut found = Self {
            fronts: Vec::new(),
            starts: vec![0; count],
            size: 0,
        };
        // Children come before parents: one pass marks the whole way up.
        for (k, front) in symbolic.fronts.iter().enumerate() {
            if reached[k] {
                found.fronts.push((k, found.size));
                found.starts[k] = found.size;
                found.size += front.width;
                if let Some(first) = symbolic.below(front).first() {
                    reached[symbolic.front_at(*first)] = true;
                }
            }
        }
        found
    }

    /// Where an unknown, by its place in the order of elimination, lies here.
    fn row(&self, symbolic: &Symbolic, place: u32) -> usize {
        let front = symbolic.front_at(place);
        self.starts[front] + place as usize - symbolic.fronts[front].first
    }
}

impl Ldl {
    /// `B A^-1 B^T` of the matrix `A` factored last, whole, with combinations for the rows of `B`: what a unit of force on one moves another by.
    pub(crate) fn compliance(&self, combinations: &Combinations) -> DMatrix<f64> {
        let (s, count) = (&self.symbolic, combinations.len());
        let reached = Reached::new(s, combinations);
        // Row by row: all right sides of an unknown lie together.
        let mut x = vec![0.0; reached.size * count];
        for (k, entries) in combinations.each().enumerate() {
            for (unknown, weight) in entries {
                x[reached.row(s, s.place(*unknown)) * count + k] += weight;
            }
        }
        let (mut pivots, mut below, mut panel) = (Vec::with_capacity(reached.size), Vec::new(), Vec::new());
        for &(number, start) in &reached.fronts {
            let front = &s.fronts[number];
            // Kept for single solutions in another order: products of many at once want columns.
            self.store.columns(front, number, &mut panel);
            let own = start * count..(start + front.width) * count;
            lower(&panel, front.size(), [0, front.width], &mut x[own.clone()], count);
            taken(&panel, front, &x[own], &mut below, count);
            for (place, below) in s.below(front).iter().zip(below.chunks_exact(count.max(1))) {
                let row = reached.row(s, *place) * count;
                x[row..row + count].iter_mut().zip(below).for_each(|(x, b)| *x -= b);
            }
            // Solutions for `L` alone are kept; pivots divide in the product, where they make it symmetric to the last bit.
            pivots.extend_from_slice(&self.store.pivots()[front.first..front.first + front.width]);
        }
        product(&x, &pivots, count)
    }
}

/// `x` becomes the solution with the unit lower triangle of columns `from` to `to` of a front.
fn lower(panel: &[f64], size: usize, [from, to]: [usize; 2], x: &mut [f64], count: usize) {
    if to - from <= NARROW {
        for k in from..to {
            let (known, rest) = x.split_at_mut((k + 1) * count);
            let known = &known[k * count..];
            for (row, l) in rest
                .chunks_exact_mut(count.max(1))
                .zip(&panel[k * size + k + 1..k * size + to])
            {
                row.iter_mut().zip(known).for_each(|(x, k)| *x -= l * k);
            }
        }
        return;
    }
    // By halves, so that most of the work is in products.
    let middle = from + (to - from) / 2;
    lower(panel, size, [from, middle], x, count);
    let (known, rest) = x.split_at_mut(middle * count);
    let (height, depth) = (to - middle, middle - from);
    let l = columns(&panel[from * size + middle..], [height, depth], size);
    let known = rows(&known[from * count..], [depth, count]);
    let (one, count_of) = (Dyn(1), Dyn(count));
    let mut rest = DMatrixViewMut::from_slice_with_strides_generic(rest, Dyn(height), count_of, count_of, one);
    rest.gemm(-1.0, &l, &known, 1.0);
    lower(panel, size, [middle, to], x, count);
}

/// What a front's solution `x` takes from the rows below it.
fn taken(panel: &[f64], front: &Front, x: &[f64], below: &mut Vec<f64>, count: usize) {
    below.clear();
    below.resize(front.height * count, 0.0);
    if below.is_empty() {
        return;
    }
    let l = columns(&panel[front.width..], [front.height, front.width], front.size());
    let (height, count_of) = (Dyn(front.height), Dyn(count));
    let mut below = DMatrixViewMut::from_slice_with_strides_generic(&mut below[..], height, count_of, count_of, Dyn(1));
    below.gemm(1.0, &l, &rows(x, [front.width, count]), 0.0);
}

/// `X^T D^-1 X`.
fn product(x: &[f64], pivots: &[f64], count: usize) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(count, count);
    // Combinations of held unknowns only reach nothing.
    if pivots.is_empty() {
        return all;
    }
    let mut scaled = Vec::new();
    for from in (0..count).step_by(STRIP) {
        let width = STRIP.min(count - from);
        scaled.clear();
        for (row, pivot) in x.chunks_exact(count).zip(pivots) {
            scaled.extend(row[from..from + width].iter().map(|x| x / pivot));
        }
        let left = columns(&x[from..], [count - from, pivots.len()], count);
        let mut strip = all.view_mut((from, from), (count - from, width));
        strip.gemm(1.0, &left, &rows(&scaled, [pivots.len(), width]), 0.0);
    }
    all.fill_upper_triangle_with_lower_triangle();
    all
}

/// A matrix of so many rows and columns, the columns `stride` entries apart.
fn columns(data: &[f64], [height, width]: [usize; 2], stride: usize) -> DMatrixView<'_, f64, Dyn, Dyn> {
    DMatrixView::from_slice_with_strides_generic(data, Dyn(height), Dyn(width), Dyn(1), Dyn(stride))
}

/// The same, row by row.
fn rows(data: &[f64], [height, width]: [usize; 2]) -> DMatrixView<'_, f64, Dyn, Dyn> {
    DMatrixView::from_slice_with_strides_generic(data, Dyn(height), Dyn(width), Dyn(width), Dyn(1))
}
