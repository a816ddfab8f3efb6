//! The rotation of 4-space nearest to a matrix.

use nalgebra::Matrix4;

use super::{RotationError, exact};

type Rows = [[f64; 4]; 4];

/// A determinant this small beside the product of the rows' norms is rounding: 24 products of four factors.
const SINGULAR_DETERMINANT: f64 = 64.0 * f64::EPSILON;

/// The orthogonal factor of the polar decomposition of a finite matrix of any scale, by Newton's iteration (Higham 1986):
/// the rotation nearest in the Frobenius norm.
///
/// Error: 8 eps times the condition number of the matrix in each entry.
///
/// # Errors
/// [`RotationError::Reflection`], [`RotationError::Singular`].
pub(super) fn polar(rows: Rows) -> Result<Rows, RotationError> {
    let most = exact::largest(rows.map(exact::largest));
    if most == 0.0 {
        return Err(RotationError::Singular { determinant: 0.0 });
    }
    // Divided by its largest entry, of which only the nearest power of two would be exact: the polar factor does not
    // depend on the scale, and half an ulp of each entry is within the bound.
    let mut x = Matrix4::from_fn(|i, j| rows[i][j] / most);
    check_determinant(&x)?;
    // As in three dimensions: each step halves the logarithms of the singular values, then squares their distance to 1.
    for _ in 0..64 {
        let inverse = x.try_inverse().ok_or(RotationError::Singular { determinant: 0.0 })?;
        let next = (x + inverse.transpose()) * 0.5;
        let moved = (next - x).amax();
        x = next;
        // The square of this is the next step's move.
        if moved < 1e-9 {
            break;
        }
    }
    Ok([0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| x[(i, j)])))
}

/// Refuses determinants that are negative, or zero to rounding beside Hadamard's bound; the largest entry is 1.
fn check_determinant(x: &Matrix4<f64>) -> Result<(), RotationError> {
    let determinant = x.determinant();
    let bound: f64 = x.row_iter().map(|row| row.norm()).product();
    if determinant.abs() <= SINGULAR_DETERMINANT * bound {
        Err(RotationError::Singular { determinant })
    } else if determinant < 0.0 {
        Err(RotationError::Reflection { determinant })
    } else {
        Ok(())
    }
}
