//! How a factor is stored for solutions.

use std::ops::Range;

use super::packed::Packed;
use super::substitution;
use super::symbolic::Symbolic;

/// How entries of `L` are stored for solutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// As they are eliminated.
    #[default]
    Double,
    /// Rounded to single precision, pivots in double: half the bytes to read. A solution has an error of about 6e-8 times
    /// the condition of the matrix, which refinement with the residual takes away where that product is below one.
    Single,
}

/// A factor as solutions read it.
#[derive(Debug, Clone, Default)]
pub(super) enum Store {
    /// Where it was eliminated.
    #[default]
    Factor,
    Double(Packed<f64>),
    Single(Packed<f32>),
}

impl Store {
    /// Takes up a factor anew: packed, or none where it is read where it was eliminated.
    pub(super) fn take_up(&mut self, packed: Option<Precision>, symbolic: &Symbolic, factor: &[f64]) {
        // A store of the same kind is filled in the memory that it has: factors of one pattern are equally long.
        match (packed, &mut *self) {
            (Some(Precision::Double), Self::Double(packed)) => packed.store(symbolic, factor),
            (Some(Precision::Single), Self::Single(packed)) => packed.store(symbolic, factor),
            (Some(Precision::Double), _) => *self = Self::Double(Packed::new(symbolic, factor)),
            (Some(Precision::Single), _) => *self = Self::Single(Packed::new(symbolic, factor)),
            (None, _) => *self = Self::Factor,
        }
    }

    /// `L x = b`, then `D x = b`, of some fronts: all where the factor is not packed.
    pub(super) fn forward(&self, symbolic: &Symbolic, factor: &[f64], fronts: Range<usize>, x: &mut [f64]) {
        match self {
            Self::Factor => substitution::forward(symbolic, factor, x),
            Self::Double(packed) => packed.forward(symbolic, fronts, x),
            Self::Single(packed) => packed.forward(symbolic, fronts, x),
        }
    }

    /// `L^T x = b` of some fronts: all where the factor is not packed.
    pub(super) fn back(&self, symbolic: &Symbolic, factor: &[f64], fronts: Range<usize>, x: &mut [f64]) {
        match self {
            Self::Factor => substitution::back(symbolic, factor, x),
            Self::Double(packed) => packed.back(symbolic, fronts, x),
            Self::Single(packed) => packed.back(symbolic, fronts, x),
        }
    }
}
