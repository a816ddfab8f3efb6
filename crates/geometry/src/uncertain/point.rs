//! A point with the covariance of its place.

use std::fmt;

use nalgebra::Matrix3;

use super::{CovarianceError, checked, symmetric};
use crate::{Frame, Point};

/// The 0.95 quantile of chi-square with three degrees of freedom (Abramowitz and Stegun 1964, table 26.8).
const CHI_SQUARE_95: f64 = 7.814_727_903_251_179;

/// A point of `F` and the 3 x 3 covariance of its error, mm^2: symmetric to the bit and positive semidefinite to rounding.
pub struct UncertainPoint<F> {
    point: Point<F>,
    covariance: Matrix3<f64>,
}

impl<F> Clone for UncertainPoint<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for UncertainPoint<F> {}
impl<F> PartialEq for UncertainPoint<F> {
    fn eq(&self, other: &Self) -> bool {
        self.point == other.point && self.covariance == other.covariance
    }
}
impl<F: Frame> fmt::Debug for UncertainPoint<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let deviations = self.covariance.diagonal().map(f64::sqrt);
        write!(f, "{:?} +- {:?} mm", self.point, deviations.as_slice())
    }
}

/// A point without error.
impl<F> From<Point<F>> for UncertainPoint<F> {
    fn from(point: Point<F>) -> Self {
        Self::wrap(point, Matrix3::zeros())
    }
}

impl<F> UncertainPoint<F> {
    /// Wraps a covariance that is one by construction.
    pub(super) fn wrap(point: Point<F>, covariance: Matrix3<f64>) -> Self {
        Self {
            point,
            covariance: symmetric(&covariance),
        }
    }

    /// A point and the covariance of its error, mm^2.
    ///
    /// # Errors
    /// Each variant of [`CovarianceError`].
    pub fn new(point: Point<F>, covariance: Matrix3<f64>) -> Result<Self, CovarianceError> {
        let covariance = checked::checked(covariance, |c| c.symmetric_eigenvalues().min())?;
        Ok(Self { point, covariance })
    }

    /// The same of a matrix by its rows, as files and messages have it.
    ///
    /// # Errors
    /// Each variant of [`CovarianceError`].
    pub fn from_rows(point: Point<F>, rows: [[f64; 3]; 3]) -> Result<Self, CovarianceError> {
        Self::new(point, Matrix3::from_fn(|row, column| rows[row][column]))
    }

    /// The point.
    pub const fn point(&self) -> Point<F> {
        self.point
    }

    /// The covariance of its error, mm^2.
    pub const fn covariance(&self) -> Matrix3<f64> {
        self.covariance
    }

    /// Root mean square length of the error, mm: the root of the covariance's trace. For the tip of a tool this is the
    /// target registration error of the literature.
    pub fn rms_mm(&self) -> f64 {
        self.covariance.trace().max(0.0).sqrt()
    }

    /// A distance from the point within which the true place lies in at least 95 of 100 cases, mm: the longest half-axis
    /// of the 95 % ellipsoid of a normal error, sqrt(7.815 times the largest eigenvalue).
    ///
    /// Exactly 95 % where the error is alike in all directions, 99.5 % where one direction outweighs the others: what is
    /// shown to a surgeon must not be too small. Error: 16 ulp.
    pub fn radius_95_mm(&self) -> f64 {
        // The covariance is semidefinite to rounding only.
        let most = self.covariance.symmetric_eigenvalues().max();
        (CHI_SQUARE_95 * most.max(0.0)).sqrt()
    }
}
