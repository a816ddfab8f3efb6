//! Rigid transforms with the covariance of their error, carried through composition and inversion to first order.
//!
//! # Convention
//!
//! The same everywhere, in registrations and on the bus. Rows and columns of a 6 x 6 covariance are (w, v): rotation
//! vector and translation, both in `To`, radians and mm. The true transform is
//!
//! ```text
//! p -> exp(w) (R p + t) + v                                                                                     (1)
//! ```
//!
//! with (R, t) the transform at hand and (w, v) of mean zero and this covariance: a small motion after the transform,
//! turning about the origin of `To`. Every result here is exact to first order in (w, v); what is left out is of the size
//! of abs(w)^2 times the distance from the point that is turned about.
//!
//! # Formulas
//!
//! A motion (w, v) before a transform is the motion Ad (w, v) after it, with the adjoint
//!
//! ```text
//! Ad(R, t) = [    R    0 ]
//!            [ [t]x R  R ]                                                                                      (2)
//! ```
//!
//! (Murray, Li and Sastry 1994, equation 2.58, with rotation before translation). Errors that are independent add:
//!
//! ```text
//! cov(A B)   = cov(A) + Ad(A) cov(B) Ad(A)^T                                                                    (3)
//! cov(A^-1)  = Ad(A^-1) cov(A) Ad(A^-1)^T                                                                       (4)
//! cov(A p)   = J cov(A) J^T + R cov(p) R^T,   J = [ -[A p]x  1 ]                                                (5)
//! about c    : v_c = v + w x c                                                                                  (6)
//! ```
//!
//! # Rounding
//!
//! Each entry is a sum of products of the matrices' entries, so its error is below 32 eps times the same sum of absolute
//! values. Far from the origin that matters: with a lever of d mm the variance at the far end is what is left of d^2 times
//! the rotation's variance. At 1e6 mm and 1e-4 rad that is 1e4 mm^2, and 1e-10 mm^2 are lost.

use std::fmt;
use std::ops::Mul;

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

use crate::{Frame, Point, Rigid};

mod checked;
mod point;

pub use checked::CovarianceError;
pub use point::UncertainPoint;

/// The transform `to_from_from` and the 6 x 6 covariance of its error: (rotation vector, translation) in `To`, rad and mm,
/// the motion of equation (1) of [the module](self).
///
/// The covariance is symmetric to the bit, finite, and positive semidefinite to rounding.
pub struct Uncertain<To, From> {
    transform: Rigid<To, From>,
    covariance: Matrix6<f64>,
}

impl<To, From> Clone for Uncertain<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Uncertain<To, From> {}
impl<To, From> PartialEq for Uncertain<To, From> {
    fn eq(&self, other: &Self) -> bool {
        self.transform == other.transform && self.covariance == other.covariance
    }
}
impl<To: Frame, From: Frame> fmt::Debug for Uncertain<To, From> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let deviations = self.covariance.diagonal().map(f64::sqrt);
        write!(f, "{:?} +- {:?} (rad, mm)", self.transform, deviations.as_slice())
    }
}

/// A transform without error.
impl<To, From_> From<Rigid<To, From_>> for Uncertain<To, From_> {
    fn from(transform: Rigid<To, From_>) -> Self {
        Self::wrap(transform, Matrix6::zeros())
    }
}

impl<To, From> Uncertain<To, From> {
    /// Wraps a covariance that is one by construction; what rounding did to its symmetry is undone.
    fn wrap(transform: Rigid<To, From>, covariance: Matrix6<f64>) -> Self {
        Self {
            transform,
            covariance: symmetric(&covariance),
        }
    }

    /// A transform and its covariance in the convention of [the module](self).
    ///
    /// # Errors
    /// Each variant of [`CovarianceError`].
    pub fn new(transform: Rigid<To, From>, covariance: Matrix6<f64>) -> Result<Self, CovarianceError> {
        let covariance = checked::checked(covariance, |c| c.symmetric_eigenvalues().min())?;
        Ok(Self { transform, covariance })
    }

    /// From the upper triangle of the covariance, row by row: the 21 numbers of messages and files. Bits are kept.
    ///
    /// # Errors
    /// Each variant of [`CovarianceError`] but the one for asymmetry.
    pub fn from_upper(transform: Rigid<To, From>, upper: [f64; 21]) -> Result<Self, CovarianceError> {
        Self::new(transform, checked::from_upper(upper))
    }

    /// From the covariance of (w, v_c), the turn about the point `c` of `To` and what `c` itself moves by (6): the form in
    /// which a registration knows it about the centre of its points.
    ///
    /// # Errors
    /// Each variant of [`CovarianceError`].
    pub fn from_covariance_about(
        c: Point<To>,
        transform: Rigid<To, From>,
        covariance: Matrix6<f64>,
    ) -> Result<Self, CovarianceError> {
        let about = Self::new(transform, covariance)?;
        // (6) solved for v: v = v_c - w x c.
        Ok(Self::wrap(transform, carried(&lever(-c.0), &about.covariance)))
    }

    /// The transform, of which the error is unknown but for its covariance.
    pub const fn transform(&self) -> Rigid<To, From> {
        self.transform
    }

    /// The covariance of (w, v) in `To`, rad and mm, as in (1): symmetric to the bit.
    pub const fn covariance(&self) -> Matrix6<f64> {
        self.covariance
    }

    /// The covariance of (w, v_c) (6): the turn, and what the point `c` of `To` moves by; rad and mm.
    pub fn covariance_about(&self, c: Point<To>) -> Matrix6<f64> {
        symmetric(&carried(&lever(c.0), &self.covariance))
    }

    /// The upper triangle of the covariance, row by row: the 21 numbers of messages and files. Exact.
    pub fn upper(&self) -> [f64; 21] {
        checked::upper(&self.covariance)
    }

    /// `from_from_to` with the covariance of its error (4), in `From`.
    pub fn inverse(&self) -> Uncertain<From, To> {
        let back = self.transform.inverse();
        // (exp(m) A)^-1 = A^-1 exp(-m): the motion -m before A^-1, which the adjoint (2) takes behind it. The sign does
        // not matter to a covariance.
        Uncertain::wrap(back, carried(&back.adjoint(), &self.covariance))
    }
}

impl<To, From> Rigid<To, From> {
    /// The adjoint (2) of [`crate::uncertain`], 6 x 6: takes a small motion (rotation vector, translation) in `From` before
    /// the transform to the motion in `To` after it that does the same; rad and mm.
    pub fn adjoint(&self) -> Matrix6<f64> {
        let turn = rows(self);
        let mut adjoint = Matrix6::zeros();
        adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        // exp(R w) (R p) + R v + t is a turn about the origin of `To` and the shift R v - R w x t = R v + t x R w.
        let lever = self.translation().0.cross_matrix() * turn;
        adjoint.fixed_view_mut::<3, 3>(3, 0).copy_from(&lever);
        adjoint
    }
}

/// The rotation matrix.
fn rows<To, From>(transform: &Rigid<To, From>) -> Matrix3<f64> {
    transform.rotation().matrix().into()
}

/// (w, v) to (w, v + w x c), 6 x 6.
fn lever(c: Vector3<f64>) -> Matrix6<f64> {
    let mut carry = Matrix6::identity();
    carry.fixed_view_mut::<3, 3>(3, 0).copy_from(&-c.cross_matrix());
    carry
}

/// J C J^T.
fn carried<const N: usize, const M: usize>(j: &SMatrix<f64, M, N>, c: &SMatrix<f64, N, N>) -> SMatrix<f64, M, M> {
    j * c * j.transpose()
}

/// The mean of the matrix and its transpose.
fn symmetric<const N: usize>(c: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    (c + c.transpose()) * 0.5
}

/// Composition; the errors of the two must be independent (3).
impl<A, B, C> Mul<Uncertain<B, C>> for Uncertain<A, B> {
    type Output = Uncertain<A, C>;
    fn mul(self, other: Uncertain<B, C>) -> Uncertain<A, C> {
        let carried = carried(&self.transform.adjoint(), &other.covariance);
        Uncertain::wrap(self.transform * other.transform, self.covariance + carried)
    }
}

/// Composition with a transform that is exact: the covariance stays as it is.
impl<A, B, C> Mul<Rigid<B, C>> for Uncertain<A, B> {
    type Output = Uncertain<A, C>;
    fn mul(self, other: Rigid<B, C>) -> Uncertain<A, C> {
        Uncertain::wrap(self.transform * other, self.covariance)
    }
}

/// Composition with a transform that is exact: the covariance is carried by its adjoint (2).
impl<A, B, C> Mul<Uncertain<B, C>> for Rigid<A, B> {
    type Output = Uncertain<A, C>;
    fn mul(self, other: Uncertain<B, C>) -> Uncertain<A, C> {
        Uncertain::wrap(self * other.transform, carried(&self.adjoint(), &other.covariance))
    }
}

/// The image of a point that is known exactly in `From`, with the covariance of its place in `To` (5).
impl<To, From> Mul<Point<From>> for Uncertain<To, From> {
    type Output = UncertainPoint<To>;
    fn mul(self, p: Point<From>) -> UncertainPoint<To> {
        self * UncertainPoint::from(p)
    }
}

/// The image of a point whose own error is independent of the transform's (5).
impl<To, From> Mul<UncertainPoint<From>> for Uncertain<To, From> {
    type Output = UncertainPoint<To>;
    fn mul(self, p: UncertainPoint<From>) -> UncertainPoint<To> {
        let place = self.transform * p.point();
        // About the image itself the block of the shift is what the image moves by: J cov J^T of (5).
        let moved = self.covariance_about(place);
        let own = carried(&rows(&self.transform), &p.covariance());
        UncertainPoint::wrap(place, moved.fixed_view::<3, 3>(3, 3) + own)
    }
}
