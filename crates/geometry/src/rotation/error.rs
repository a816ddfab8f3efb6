//! Why numbers do not make a rotation.

use std::fmt;

/// Why numbers were refused as a rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RotationError {
    /// A number is NaN.
    Nan {
        /// What was being read, for instance `quaternion`.
        what: &'static str,
        /// Which of its numbers, counted from 0 (matrices by rows).
        index: usize,
    },
    /// A number is infinite.
    Infinite {
        /// What was being read.
        what: &'static str,
        /// Which of its numbers, counted from 0 (matrices by rows).
        index: usize,
    },
    /// Every component of a quaternion, complex number or axis is zero: it has no direction.
    Zero {
        /// What was being read.
        what: &'static str,
    },
    /// A matrix has a negative determinant: it turns a right hand into a left one.
    Reflection {
        /// The determinant found.
        determinant: f64,
    },
    /// A matrix flattens space, to working precision: no rotation is nearest to it by polar decomposition.
    Singular {
        /// The determinant found, after the largest entry was scaled to between 1 and 2.
        determinant: f64,
    },
    /// A matrix is further from the nearest rotation than the tolerance.
    NotOrthonormal {
        /// Frobenius norm of the difference to the nearest rotation.
        distance: f64,
        /// The largest accepted distance.
        tolerance: f64,
    },
    /// A matrix has not as many rows as columns.
    NotSquare {
        /// How many rows.
        rows: usize,
        /// How many columns.
        columns: usize,
    },
    /// A mean of no rotations, or of as many weights as there are not rotations.
    Count {
        /// How many rotations.
        rotations: usize,
        /// How many weights.
        weights: usize,
    },
    /// A weight is negative, or all are zero.
    Weight {
        /// Which weight, counted from 0; 0 where all are zero.
        index: usize,
    },
    /// The rotations are spread so that no mean is singled out.
    NoMean,
}

impl fmt::Display for RotationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nan { what, index } => write!(f, "{what}: number {index} is NaN, every number must be finite"),
            Self::Infinite { what, index } => {
                write!(f, "{what}: number {index} is infinite, every number must be finite")
            }
            Self::Zero { what } => write!(f, "{what}: all zeros, a length above zero is needed"),
            Self::Reflection { determinant } => {
                write!(
                    f,
                    "matrix: a reflection, determinant {determinant}, not a rotation: exchange or negate one axis"
                )
            }
            Self::Singular { determinant } => {
                write!(
                    f,
                    "matrix: singular, determinant {determinant:e} once scaled to 1: its rows are dependent"
                )
            }
            Self::NotOrthonormal { distance, tolerance } => {
                write!(
                    f,
                    "matrix: {distance:e} from the nearest rotation, more than the {tolerance:e} allowed"
                )
            }
            Self::NotSquare { rows, columns } => {
                write!(f, "matrix: {rows} x {columns}, as many rows as columns are needed")
            }
            Self::Count { rotations, weights } => {
                write!(
                    f,
                    "mean: {rotations} rotations and {weights} weights, as many of each and at least one are needed"
                )
            }
            Self::Weight { index } => write!(f, "mean: weight {index} must be positive or zero, and one above zero"),
            Self::NoMean => write!(f, "mean: the rotations are spread so widely that none is their mean"),
        }
    }
}

impl std::error::Error for RotationError {}

/// Refuses the first number that is not finite, and says which of the two it is.
pub(crate) fn finite(what: &'static str, numbers: &[f64]) -> Result<(), RotationError> {
    match numbers.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(index) if numbers[index].is_nan() => Err(RotationError::Nan { what, index }),
        Some(index) => Err(RotationError::Infinite { what, index }),
    }
}
