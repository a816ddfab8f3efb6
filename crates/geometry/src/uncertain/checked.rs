//! Which numbers are a covariance.

use std::fmt;

use nalgebra::{Matrix6, SMatrix};

/// Why numbers were refused as a covariance. Rows and columns count from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CovarianceError {
    /// A number is NaN or infinite.
    NotFinite {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// The number found.
        found: f64,
    },
    /// A variance is negative.
    NegativeVariance {
        /// Its row and column.
        index: usize,
        /// The number found.
        found: f64,
    },
    /// Two numbers across the diagonal differ by more than rounding.
    Asymmetric {
        /// The row of the first.
        row: usize,
        /// The column of the first.
        column: usize,
        /// The two numbers.
        found: [f64; 2],
    },
    /// Some combination of the errors would have a negative variance, by more than rounding.
    NotSemidefinite {
        /// The least eigenvalue of the matrix of correlations, of no unit.
        least: f64,
        /// What rounding may bring it down to.
        allowed: f64,
    },
}

impl fmt::Display for CovarianceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { row, column, found } => {
                write!(
                    f,
                    "covariance: {found} in row {row}, column {column}, every number must be finite"
                )
            }
            Self::NegativeVariance { index, found } => {
                write!(
                    f,
                    "covariance: variance {index} is {found:e}, it must be positive or zero"
                )
            }
            Self::Asymmetric {
                row,
                column,
                found: [a, b],
            } => write!(
                f,
                "covariance: {a:e} in row {row}, column {column}, but {b:e} across the diagonal: it must be symmetric"
            ),
            Self::NotSemidefinite { least, allowed } => write!(
                f,
                "covariance: not positive semidefinite, least eigenvalue of the correlations {least:e}, allowed {allowed:e}"
            ),
        }
    }
}

impl std::error::Error for CovarianceError {}

/// What rounding may do to an entry, as a share of the root of the product of its two variances: a congruence J C J^T of
/// size 6 adds 24 roundings of half an ulp, and ten times that is left for what cancels in it.
const ROUNDING: f64 = 128.0 * f64::EPSILON;

/// The matrix with its two triangles averaged, if it is a covariance; `least` gives a symmetric matrix' least eigenvalue.
///
/// The test is on the correlations c_ij / sqrt(c_ii c_jj), so that it does not depend on units. If each of their entries is
/// within [`ROUNDING`] of those of a semidefinite matrix, no eigenvalue is below -N times that (Weyl).
pub(super) fn checked<const N: usize>(
    c: SMatrix<f64, N, N>,
    least: impl Fn(&SMatrix<f64, N, N>) -> f64,
) -> Result<SMatrix<f64, N, N>, CovarianceError> {
    // First, so that no comparison below meets a NaN or the root of a negative variance.
    entries(&c)?;
    let deviation = c.diagonal().map(f64::sqrt);
    // Divided one after the other: the product may be below the smallest number. Where a variance is zero, so is its row.
    let relative = |x: f64, i: usize, j: usize| {
        if x == 0.0 { 0.0 } else { x / deviation[i] / deviation[j] }
    };
    for (i, j) in (0..N).flat_map(|i| (0..i).map(move |j| (j, i))) {
        let found = [c[(i, j)], c[(j, i)]];
        if relative(found[0] - found[1], i, j).abs() > ROUNDING {
            return Err(CovarianceError::Asymmetric {
                row: i,
                column: j,
                found,
            });
        }
    }
    // Where both triangles agree the bits are kept; else halved first, as the sum of two large numbers may overflow.
    let mean = c.zip_map(&c.transpose(), |a, b| if a == b { a } else { 0.5 * a + 0.5 * b });
    let correlation = SMatrix::<f64, N, N>::from_fn(|i, j| relative(mean[(i, j)], i, j));
    let allowed = -(N as f64) * ROUNDING;
    // Beyond 1 to rounding there is no such correlation, and eigenvalues of what is not finite are not to be had.
    let most = correlation.amax();
    if most > 1.0 - allowed {
        let least = 1.0 - most;
        return Err(CovarianceError::NotSemidefinite { least, allowed });
    }
    match least(&correlation) {
        low if low >= allowed => Ok(mean),
        least => Err(CovarianceError::NotSemidefinite { least, allowed }),
    }
}

/// Refuses what is not finite, and negative variances.
fn entries<const N: usize>(c: &SMatrix<f64, N, N>) -> Result<(), CovarianceError> {
    for (row, column) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
        let found = c[(row, column)];
        if !found.is_finite() {
            return Err(CovarianceError::NotFinite { row, column, found });
        }
    }
    match (0..N).find(|&i| c[(i, i)] < 0.0) {
        Some(index) => Err(CovarianceError::NegativeVariance {
            index,
            found: c[(index, index)],
        }),
        None => Ok(()),
    }
}

/// The place of row i, column j >= i in the upper triangle, row by row.
const fn place(i: usize, j: usize) -> usize {
    // Rows before i hold 6 + 5 + ... = i (13 - i) / 2 entries; row i begins with column i.
    i * (11 - i) / 2 + j
}

/// The symmetric matrix with this upper triangle, row by row.
pub(super) fn from_upper(upper: [f64; 21]) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| upper[place(i.min(j), i.max(j))])
}

/// The upper triangle, row by row.
pub(super) fn upper(c: &Matrix6<f64>) -> [f64; 21] {
    let mut upper = [0.0; 21];
    for (i, j) in (0..6).flat_map(|i| (i..6).map(move |j| (i, j))) {
        upper[place(i, j)] = c[(i, j)];
    }
    upper
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangle_goes_row_by_row() {
        let mut next = 0;
        for i in 0..6 {
            for j in i..6 {
                assert_eq!(place(i, j), next);
                next += 1;
            }
        }
    }
}
