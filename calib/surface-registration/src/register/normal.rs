//! Normal equations of the unknowns: their inverse, and what they answer to a pull.

use super::parts::FREE_MM;
use crate::solve::{Matrix8, Vector8};

/// The inverse of normal equations; what nothing holds has the deviation [`FREE_MM`].
///
/// Turns are counted in mm at the points' radius, so that a direction of all eight unknowns has one unit.
pub(super) fn held(matrix: &Matrix8, radius_mm: f64) -> Matrix8 {
    let unit = units(radius_mm);
    let eigen = (unit * matrix * unit).symmetric_eigen();
    let least = FREE_MM.powi(-2);
    let inverse = eigen.eigenvalues.map(|value| 1.0 / value.max(least));
    unit * (eigen.eigenvectors * Matrix8::from_diagonal(&inverse) * eigen.eigenvectors.transpose()) * unit
}

/// What normal equations answer to `pull`; what nothing holds moves freely, with the deviation [`FREE_MM`].
pub(super) fn solved(matrix: &Matrix8, pull: &Vector8, radius_mm: f64) -> Vector8 {
    let unit = units(radius_mm);
    // Asked for each point: eigenvalues would cost more.
    let floored = unit * matrix * unit + Matrix8::identity() * FREE_MM.powi(-2);
    match floored.cholesky() {
        Some(factor) => unit * factor.solve(&(unit * pull)),
        // Rounding alone makes it indefinite.
        None => held(matrix, radius_mm) * pull,
    }
}

/// From mm at the points to rad, mm, share at a depth of 50 mm, mm.
fn units(radius_mm: f64) -> Matrix8 {
    let r = 1.0 / radius_mm;
    Matrix8::from_diagonal(&[r, r, r, 1.0, 1.0, 1.0, 0.02, 1.0].into())
}
