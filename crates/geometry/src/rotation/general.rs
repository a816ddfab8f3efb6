//! The exponential of a skew matrix of any size.

use nalgebra::DMatrix;

use super::RotationError;
use super::error::finite;

/// The exponential of a skew matrix of any size through the eigenvectors of -H^2 (2.13, 2.14).
///
/// A cross-check of the closed forms, and the way to larger dimensions. Domain: finite square matrices; what is not skew
/// about them is dropped; squares of angles below 1e-150 vanish, which leaves 1 + H. Error: 16 n eps (1 + abs(H)^2) of 1
/// in Frobenius norm: cosine and cardinal sine are smooth in the squared angles, whose rounding is n eps abs(H)^2.
///
/// # Errors
/// [`RotationError::Nan`], [`RotationError::Infinite`], [`RotationError::NotSquare`].
pub fn exp_skew(h: &DMatrix<f64>) -> Result<DMatrix<f64>, RotationError> {
    finite("skew matrix", h.as_slice())?;
    if !h.is_square() {
        return Err(RotationError::NotSquare {
            rows: h.nrows(),
            columns: h.ncols(),
        });
    }
    let h = (h - h.transpose()) * 0.5;
    let eigen = (-(&h * &h)).symmetric_eigen();
    // -H^2 = H^T H is semidefinite; rounding may leave an eigenvalue below zero.
    let angles = eigen.eigenvalues.map(|square| square.max(0.0).sqrt());
    let even = DMatrix::from_diagonal(&angles.map(f64::cos));
    let odd = DMatrix::from_diagonal(&angles.map(sinc));
    let omega = &eigen.eigenvectors;
    // exp H = cos(A) + H sin(A) / A with A the root of -H^2: even powers of H are powers of H^2, odd ones H times such.
    Ok(omega * even * omega.transpose() + h * omega * odd * omega.transpose())
}

/// sin(x) / x, 1 where that is 1 to rounding.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-8 { 1.0 } else { x.sin() / x }
}
