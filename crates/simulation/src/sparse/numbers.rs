//! The numbers of an elimination, front by front: what is left below a front waits for its parent.

use super::extend::{Left, add};
use super::front::{Factor, Scratch, Vanished, eliminate, subtract};
use super::number::Number;
use super::symbolic::{Front, Symbolic};

/// What is eliminated: a matrix, `scale` times it and what is added to its diagonal.
#[derive(Clone, Copy)]
pub(super) struct Matrix<'a> {
    pub(super) symbolic: &'a Symbolic,
    pub(super) values: &'a Values,
    /// By unknown, in the order of elimination.
    pub(super) shifts: &'a [f64],
    /// A power of two.
    pub(super) scale: f64,
}

/// The entries of a matrix, each once, in the order of their places in the fronts' columns.
#[derive(Debug, Clone, Default)]
pub(super) struct Values {
    pub(super) places: Vec<u32>,
    pub(super) values: Vec<f64>,
    /// The first entry of each front, and the end.
    pub(super) starts: Vec<usize>,
}

impl Matrix<'_> {
    /// The power of two that brings the largest entry near 1, for numbers of a narrow range.
    pub(super) fn unit(&self) -> f64 {
        let all = self.values.values.iter().chain(self.shifts);
        let largest = all.fold(0.0_f64, |most, value| most.max(value.abs()));
        // As far as a power of two and its inverse go: then of an entry that is 0 or no number too.
        2.0_f64.powf(-largest.clamp(1e-300, 1e300).log2().round())
    }
}

/// How the columns of a front are kept.
pub(super) type Keep<E, T> = fn(&Front, &[E], &mut [T]);

/// Where a front's columns and pivots are kept.
pub(super) struct Room<'a, T> {
    pub(super) entries: &'a mut [T],
    pub(super) pivots: &'a mut [f64],
}

/// Memory of one thread's elimination.
#[derive(Debug, Clone, Default)]
pub(super) struct Worker<E> {
    /// What fronts left behind and no other has taken yet: dense lower triangles.
    pub(super) left: Vec<Left<E>>,
    /// Memory for what will be left.
    pub(super) spare: Vec<Vec<E>>,
    pub(super) panel: Vec<E>,
    pub(super) diagonal: Vec<E>,
    pub(super) scratch: Scratch<E>,
}

impl<E: Number> Worker<E> {
    pub(super) fn clear(&mut self) {
        self.spare.extend(self.left.drain(..).map(|(_, left)| left));
    }

    /// Eliminates a front. How many pivots are negative: at `most` of them it ends.
    pub(super) fn front<T>(
        &mut self,
        matrix: Matrix<'_>,
        number: usize,
        keep: Keep<E, T>,
        room: Room<'_, T>,
        most: usize,
    ) -> Result<usize, Vanished> {
        let front = &matrix.symbolic.fronts[number];
        let mut own = self.assemble(matrix, number);
        let negative = self.eliminate(matrix, front, most)?;
        // Only the number of negative pivots was asked for, up to that many.
        if negative < most {
            let factor = Factor {
                columns: &self.panel,
                size: front.size(),
                skip: front.width,
            };
            // What the children left is in there already: after this it is what goes to the parent.
            subtract(&factor, &mut own, front.height, front.height, &mut self.scratch);
            if front.height > 0 {
                self.left.push((number, own));
            }
        }
        self.keep(matrix, front, keep, room);
        Ok(negative)
    }

    /// Eliminates the columns that were assembled. A pivot that vanished is named as it is without the scale.
    pub(super) fn eliminate(&mut self, matrix: Matrix<'_>, front: &Front, most: usize) -> Result<usize, Vanished> {
        eliminate(&mut self.panel, front.size(), &self.diagonal, most, &mut self.scratch)
            .map_err(|(column, pivot, diagonal)| (column, pivot / matrix.scale, diagonal / matrix.scale))
    }

    /// Stores the columns that were eliminated, and their pivots without the scale.
    pub(super) fn keep<T>(&self, matrix: Matrix<'_>, front: &Front, keep: Keep<E, T>, room: Room<'_, T>) {
        keep(front, &self.panel, room.entries);
        let diagonal = self.panel.iter().step_by(front.size() + 1);
        let pivots = room.pivots.iter_mut().zip(diagonal);
        pivots.for_each(|(kept, pivot)| *kept = pivot.value() / matrix.scale);
    }

    /// Takes up a front's part of the matrix, in `panel`, and sums what its children left where it needs it (Duff and Reid 1983): what
    /// that is below its columns.
    pub(super) fn assemble(&mut self, matrix: Matrix<'_>, number: usize) -> Vec<E> {
        let front = &matrix.symbolic.fronts[number];
        self.fill(matrix, number);
        let mut own = self.zeros(front.height);
        let children = self.left.len() - front.children;
        let parts = [&mut self.panel[..], &mut own[..]];
        add(
            matrix.symbolic,
            &self.left[children..],
            front,
            parts,
            self.scratch.threads,
        );
        // The children are used up.
        self.spare.extend(self.left.drain(children..).map(|(_, left)| left));
        own
    }

    /// The matrix's own entries in a front's columns.
    fn fill(&mut self, matrix: Matrix<'_>, number: usize) {
        let (front, values) = (&matrix.symbolic.fronts[number], matrix.values);
        self.panel.clear();
        // Zeros first, as some entries come from nowhere and others from several.
        self.panel.resize(front.width * front.size(), E::default());
        let own = values.starts[number]..values.starts[number + 1];
        for (place, value) in values.places[own.clone()].iter().zip(&values.values[own]) {
            self.panel[*place as usize - front.start] = E::rounded(matrix.scale * value);
        }
        self.diagonal.clear();
        let shifts = matrix.shifts[front.first..].iter();
        for (entry, shift) in self.panel.iter_mut().step_by(front.size() + 1).zip(shifts) {
            *entry += E::rounded(matrix.scale * shift);
            self.diagonal.push(*entry);
        }
    }

    /// A square of zeros on and below its diagonal.
    fn zeros(&mut self, side: usize) -> Vec<E> {
        let length = side * side;
        let mut own = self.memory(length);
        // What it held before serves where it is long enough: above the diagonal anything may be.
        if own.capacity() < length {
            own.clear();
        }
        own.resize(length, E::default());
        for (k, column) in own.chunks_exact_mut(side.max(1)).enumerate() {
            column[k..].fill(E::default());
        }
        own
    }

    /// The smallest memory that is long enough, or else the longest.
    fn memory(&mut self, length: usize) -> Vec<E> {
        if length == 0 {
            return Vec::new();
        }
        let fits = |k: &usize| self.spare[*k].capacity();
        let enough = (0..self.spare.len()).filter(|k| fits(k) >= length).min_by_key(fits);
        let best = enough.or_else(|| (0..self.spare.len()).max_by_key(fits));
        best.map_or_else(Vec::new, |k| self.spare.swap_remove(k))
    }
}
