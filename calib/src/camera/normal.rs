//! The normal equations of a view, and those of what all views share with the poses eliminated.
//!
//! Of what is shared, `c`, and a motion of the pose, `(w, v)`, with `J = d predicted / dc` and
//! `P = d predicted / d(w, v)` in one row:
//!
//! ```text
//! sum [J P r]^T W [J P r] = own  mixed  pull
//!                                 pose  turn                                                                    (8)
//! ```

use nalgebra::{Matrix2, Matrix6, SMatrix, SVector, Vector6};

use super::model::PARAMETERS;
use super::plate::Bend;
use super::predict::{Eye, slopes};
use super::view::Station;

/// What all views share: the camera's numbers, then the plate's.
pub(super) const SHARED: usize = PARAMETERS + Bend::NUMBERS;
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
const ALL: usize = SHARED + 6;
/// A row of a view's equations: derivatives and the residual, in units of deviations.
type Row = [f64; ALL + 1];

impl Normal {
    pub(super) fn of(station: &Station, eye: &Eye, free: &[bool; SHARED]) -> Self {
        let mut products = [[0.0; ALL + 1]; ALL + 1];
        for s in &station.sightings {
            let (at, (by_numbers, by_pose)) = slopes(s, eye);
            let residual = s.pixel - at;
            let row = |k: usize| -> Row {
                std::array::from_fn(|i| match i {
                    i if i < SHARED => f64::from(u8::from(free[i])) * by_numbers[(k, i)],
                    ALL => residual[k],
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

    fn from_products(products: &[Row; ALL + 1]) -> Self {
        Self {
            own: Square::from_fn(|i, j| products[i][j]),
            pull: Numbers::from_fn(|i, _| products[i][ALL]),
            mixed: Mixed::from_fn(|i, j| products[i][SHARED + j]),
            pose: Matrix6::from_fn(|i, j| products[SHARED + i][SHARED + j]),
            turn: Vector6::from_fn(|i, _| products[SHARED + i][ALL]),
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
    let a = matrix[(0, 0)].sqrt().max(f64::MIN_POSITIVE);
    let b = matrix[(0, 1)] / a;
    [[a, b], [0.0, (matrix[(1, 1)] - b * b).max(0.0).sqrt()]]
}

/// Adds the outer product of a row.
fn add(products: &mut [Row; ALL + 1], row: &Row) {
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
