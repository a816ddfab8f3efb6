//! The normal equations of a view, and those of what all views share with the poses eliminated.
//!
//! Of what is shared, `c`, and a motion of the pose, `(w, v)`, with `J = d predicted / dc` and
//! `P = d predicted / d(w, v)` in one row:
//!
//! ```text
//! sum [J P r]^T W [J P r] = own  mixed  pull
//!                                 pose  turn                                                                    (8)
//! ```

use nalgebra::{DMatrix, Matrix2, Matrix6, SMatrix, SVector, Vector6};

use super::paraboloid::SHARED;
use super::predict::{Eye, slopes};
use super::view::Station;

/// The numbers that are shared.
pub(super) type Numbers = SVector<f64, SHARED>;
/// Their normal equations.
pub(super) type Square = SMatrix<f64, SHARED, SHARED>;
/// These numbers by a pose.
pub(super) type Mixed = SMatrix<f64, SHARED, 6>;

/// The normal equations of one view.
#[derive(Debug, Clone)]
pub(super) struct Normal {
    /// `sum J^T W J`.
    pub(super) own: Square,
    /// `sum J^T W r`.
    pub(super) pull: Numbers,
    /// `E`.
    pub(super) mixed: Mixed,
    /// `H`.
    pub(super) pose: Matrix6<f64>,
    /// `h`.
    pub(super) turn: Vector6<f64>,
    /// What damping adds its share of: the diagonals of `sum J^T W J` and of `H`.
    pub(super) spread: (Numbers, Vector6<f64>),
}

/// The unknowns of one view: what is shared, then the pose.
const VIEW_UNKNOWNS: usize = SHARED + 6;
/// A row of a view's equations: derivatives and the residual, in units of deviations.
type Row = [f64; VIEW_UNKNOWNS + 1];

impl Normal {
    pub(super) fn of(station: &Station, eye: &Eye, free: &[bool; SHARED]) -> Self {
        let mut products = [[0.0; VIEW_UNKNOWNS + 1]; VIEW_UNKNOWNS + 1];
        for s in &station.sightings {
            let (at, (by_numbers, by_pose)) = slopes(s, eye);
            let residual = s.pixel - at;
            let row = |k: usize| -> Row {
                std::array::from_fn(|i| match i {
                    i if i < SHARED => f64::from(u8::from(free[i])) * by_numbers[(k, i)],
                    VIEW_UNKNOWNS => residual[k],
                    i => by_pose[(k, i - SHARED)],
                })
            };
            let rows = [row(0), row(1)];
            for [a, b] in roots(&s.information) {
                let row: Row = std::array::from_fn(|i| a * rows[0][i] + b * rows[1][i]);
                add(&mut products, &row);
            }
        }
        Self::from_products(&products)
    }

    fn from_products(products: &[Row; VIEW_UNKNOWNS + 1]) -> Self {
        Self {
            own: Square::from_fn(|i, j| products[i][j]),
            pull: Numbers::from_fn(|i, _| products[i][VIEW_UNKNOWNS]),
            mixed: Mixed::from_fn(|i, j| products[i][SHARED + j]),
            pose: Matrix6::from_fn(|i, j| products[SHARED + i][SHARED + j]),
            turn: Vector6::from_fn(|i, _| products[SHARED + i][VIEW_UNKNOWNS]),
            spread: (
                Numbers::from_fn(|i, _| products[i][i]),
                Vector6::from_fn(|i, _| products[SHARED + i][SHARED + i]),
            ),
        }
    }

    /// `H^-1`, its diagonal grown by the share `damping`; none where the discs do not hold the pose.
    pub(super) fn inverse(&self, damping: f64) -> Option<Matrix6<f64>> {
        let mut pose = self.pose;
        pose.set_diagonal(&(self.pose.diagonal() + self.spread.1 * damping));
        pose.cholesky().map(|c| c.inverse())
    }
}

/// Rows whose outer products sum to a positive definite matrix.
pub(super) fn roots(matrix: &Matrix2<f64>) -> [[f64; 2]; 2] {
    // The rows of Cholesky's factor, which make weighted squares plain ones; a weight of 0 must not become a NaN.
    let a = matrix[(0, 0)].sqrt().max(f64::MIN_POSITIVE);
    let b = matrix[(0, 1)] / a;
    [[a, b], [0.0, (matrix[(1, 1)] - b * b).max(0.0).sqrt()]]
}

/// Adds the outer product of a row.
fn add(products: &mut [Row; VIEW_UNKNOWNS + 1], row: &Row) {
    for (sums, a) in products.iter_mut().zip(row) {
        for (sum, b) in sums.iter_mut().zip(row) {
            *sum += a * b;
        }
    }
}

/// `S` and `s` of (4), with the inverses of the poses' parts; `S` has 1 for each number that is held.
pub(super) struct Reduced {
    pub(super) matrix: Square,
    pub(super) vector: Numbers,
    pub(super) inverses: Vec<Matrix6<f64>>,
}

impl Reduced {
    pub(super) fn of(normals: &[Normal], free: &[bool; SHARED], damping: f64) -> Option<Self> {
        let (mut matrix, mut vector) = (Square::zeros(), Numbers::zeros());
        let mut inverses = Vec::with_capacity(normals.len());
        for n in normals {
            let inverse = n.inverse(damping)?;
            let carried = n.mixed * inverse;
            let own = n.own + Square::from_diagonal(&(n.spread.0 * damping));
            matrix += own - carried * n.mixed.transpose();
            vector += n.pull - carried * n.turn;
            inverses.push(inverse);
        }
        for k in (0..SHARED).filter(|k| !free[*k]) {
            matrix[(k, k)] = 1.0;
        }
        Some(Self {
            matrix,
            vector,
            inverses,
        })
    }
}

/// The least eigenvalue of shared numbers, brought to a unit diagonal, that is no rounding.
pub(super) const HELD: f64 = 1e-13;

/// The least eigenvalue of a symmetric matrix brought to a unit diagonal (pixels and coefficients are of different size),
/// and the shared number, one of its first, that has most of it.
pub(super) fn loosest(matrix: &DMatrix<f64>) -> (f64, usize) {
    // Of what is no number eigenvalues are looked for without end.
    if !matrix.iter().all(|v| v.is_finite()) {
        return (f64::NAN, 0);
    }
    let size = matrix.diagonal().map(|d| d.max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        size[i] * matrix[(i, j)] * size[j]
    });
    let eigen = scaled.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let shared = eigen.eigenvectors.column(least).rows(0, SHARED).iamax();
    (eigen.eigenvalues[least], shared)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loosest_number_is_told_whatever_the_units_and_what_is_no_number_is_not_looked_at() {
        let units = |k: usize| [1e3, 1e-2, 1.0][k % 3];
        // All alone but 2 and 5, which all but go together: the least eigenvalue is 1 - 0.9999.
        let of = |i: usize, j: usize| match (i.min(j), i.max(j)) {
            (i, j) if i == j => 1.0,
            (2, 5) => 0.9999,
            _ => 0.0,
        };
        let mut matrix = DMatrix::from_fn(SHARED + 4, SHARED + 4, |i, j| units(i) * of(i, j) * units(j));
        let (least, shared) = loosest(&matrix);
        assert!(
            (least - 1e-4).abs() < 1e-12 && [2, 5].contains(&shared),
            "{least} {shared}"
        );
        matrix[(0, 0)] = f64::NAN;
        assert!(loosest(&matrix).0.is_nan());
    }
}
