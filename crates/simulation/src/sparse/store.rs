//! How a factor is kept for solutions.

use std::ops::Range;

use super::kept::Kept;
use super::number::Number;
use super::numbers::Keep;
use super::packed::{keep, length};
use super::parallel::Place;
use super::substitution;
use super::symbolic::{Front, Symbolic};

/// What a factor is computed and kept in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// Double precision.
    #[default]
    Double,
    /// Eliminated in double precision and kept rounded to single, pivots in double: half the bytes to read. A solution has an error of
    /// about 6e-8 times the condition of the matrix, which refinement with the residual takes away where that product is below one.
    Single,
    /// Eliminated in single precision too: half the bytes and twice the rate of products. Rounding is some hundred times that of `Single`, and with
    /// it what refinement leaves at each solution; a pivot below 5e-6 of its diagonal entry counts as zero. Where a matrix is
    /// that near to a singular one, its inertia may be another.
    SingleThroughout,
}

impl<T: Number> Kept<T> {
    /// Room for a factor whose fronts have so many entries each.
    fn room<E>(&mut self, symbolic: &Symbolic, keep: Keep<E, T>, length: fn(&Front) -> usize) -> Place<'_, E, T> {
        self.starts.clear();
        let mut end = 0;
        for front in &symbolic.fronts {
            self.starts.push(end);
            end += length(front);
        }
        self.starts.push(end);
        // Nothing is cleared: what is solved with is written.
        self.entries.resize(end, T::default());
        self.pivots.clear();
        self.pivots.resize(symbolic.order.len(), 0.0);
        Place {
            entries: &mut self.entries,
            pivots: &mut self.pivots,
            starts: &self.starts,
            keep,
        }
    }

    /// Room for packed columns.
    pub(super) fn packed<E: Number>(&mut self, symbolic: &Symbolic) -> Place<'_, E, T> {
        self.room(symbolic, keep::<E, T>, length)
    }

    /// Room for columns as they are eliminated.
    pub(super) fn whole(&mut self, symbolic: &Symbolic) -> Place<'_, T, T> {
        let copy = |_: &Front, panel: &[T], entries: &mut [T]| entries.copy_from_slice(panel);
        self.room(symbolic, copy, |front| front.panel().len())
    }
}

/// How columns are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Form {
    /// In double precision as they are eliminated.
    #[default]
    Whole,
    Double,
    Single,
}

/// A factor as solutions read it.
#[derive(Debug, Clone, Default)]
pub(super) struct Store {
    form: Form,
    pub(super) double: Kept<f64>,
    pub(super) single: Kept<f32>,
}

impl Store {
    /// Takes a form, and forgets a factor in another.
    pub(super) fn set(&mut self, form: Form) {
        if form != self.form {
            *self = Self {
                form,
                ..Self::default()
            };
        }
    }

    pub(super) fn pivots(&self) -> &[f64] {
        match self.form {
            Form::Whole | Form::Double => &self.double.pivots,
            Form::Single => &self.single.pivots,
        }
    }

    /// `L x = b`, then `D x = b`, of some fronts.
    pub(super) fn forward(&self, symbolic: &Symbolic, fronts: Range<usize>, x: &mut [f64]) {
        match self.form {
            Form::Whole => substitution::forward(symbolic, fronts, &self.double.entries, x),
            Form::Double => self.double.forward(symbolic, fronts, x),
            Form::Single => self.single.forward(symbolic, fronts, x),
        }
    }

    /// `L^T x = b` of some fronts.
    pub(super) fn back(&self, symbolic: &Symbolic, fronts: Range<usize>, x: &mut [f64]) {
        match self.form {
            Form::Whole => substitution::back(symbolic, fronts, &self.double.entries, x),
            Form::Double => self.double.back(symbolic, fronts, x),
            Form::Single => self.single.back(symbolic, fronts, x),
        }
    }
}
