//! What is known of a plate's field after an adjustment, with all it was adjusted with.

use nalgebra::{DMatrix, DVector, Matrix6};

use super::normal::Square;
use super::paraboloid::SHARED;
use super::plate_field::Waves;

/// A field that was adjusted.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub(super) waves: Waves,
    /// Coefficients of the waves: of the height, then of the plane's first and second axis, mm.
    pub(super) coefficients: DVector<f64>,
    /// Standard deviations of the prior, of the height and in the plane, mm.
    pub(super) prior_sd_mm: [f64; 2],
    /// How many coefficients of the field the discs fix.
    pub(super) effective_parameters: f64,
    /// The inverse of the system: shared numbers, poses, field.
    pub(super) inverse: DMatrix<f64>,
}

impl Field {
    /// The part of what all views share.
    pub(super) fn shared(&self, free: &[bool; SHARED]) -> Square {
        let held = |i: usize, j: usize| if free[i] && free[j] { self.inverse[(i, j)] } else { 0.0 };
        Square::from_fn(held)
    }

    /// The part of a view's pose.
    pub(super) fn pose(&self, view: usize) -> Matrix6<f64> {
        let at = SHARED + 6 * view;
        self.inverse.fixed_view::<6, 6>(at, at).into_owned()
    }

    /// The part of the plate: from its bend on, and of the field.
    pub(super) fn plate(&self, from: usize) -> DMatrix<f64> {
        let field = self.inverse.nrows() - self.coefficients.len();
        let at = |k: usize| {
            if k < SHARED - from {
                from + k
            } else {
                field + k - (SHARED - from)
            }
        };
        let size = SHARED - from + self.coefficients.len();
        DMatrix::from_fn(size, size, |i, j| self.inverse[(at(i), at(j))])
    }
}
