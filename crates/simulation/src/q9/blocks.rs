//! What a Gauss point adds to the forces and the stiffness of its element.

use nalgebra::{Matrix2, Matrix4, SMatrix, SVector, Vector4};

use super::{GaussPoint, NODES};
use crate::law::Material;

/// Degrees of freedom: `(x, y)` of node 0, of node 1, ...
pub(crate) const DOFS: usize = 2 * NODES;

/// The stiffness of an element.
pub(crate) type Stiffness = SMatrix<f64, DOFS, DOFS>;
/// The forces on its nodes.
pub(crate) type Forces = SVector<f64, DOFS>;

pub(super) fn clamped(material: &Material, tangent: Matrix4<f64>, g: &Matrix2<f64>, convex: bool) -> Matrix4<f64> {
    if convex { material.convex(&tangent, g) } else { tangent }
}

/// `f_ni += H P_iJ Q_nJ` (II 3.13).
#[inline]
pub(super) fn add_forces(point: &GaussPoint, stress: &Vector4<f64>, forces: &mut Forces) {
    let p = stress * point.weight;
    for (n, q) in point.slopes.iter().enumerate() {
        forces[2 * n] += p[0] * q.x + p[2] * q.y;
        forces[2 * n + 1] += p[1] * q.x + p[3] * q.y;
    }
}

/// The blocks of two nodes `n >= m` of a stiffness, each column by column.
pub(super) struct Blocks([[f64; 4]; NODES * (NODES + 1) / 2]);

impl Default for Blocks {
    fn default() -> Self {
        Self([[0.0; 4]; NODES * (NODES + 1) / 2])
    }
}

impl Blocks {
    /// `K_(ni)(mk) += H Q_nJ A_(iJ)(kL) Q_mL`.
    #[inline]
    pub(super) fn add(&mut self, point: &GaussPoint, tangent: &Matrix4<f64>) {
        let a = tangent * point.weight;
        let mut rest = self.0.as_mut_slice();
        for (m, qm) in point.slopes.iter().enumerate() {
            // A contracted with Q_m: a column holds the stress that moving node m along one axis causes.
            let x: Vector4<f64> = a.column(0) * qm.x + a.column(2) * qm.y;
            let y: Vector4<f64> = a.column(1) * qm.x + a.column(3) * qm.y;
            // Both columns of a block at once, so that the innermost loop is four products wide.
            let (by_x, by_y) = ([x[0], x[1], y[0], y[1]], [x[2], x[3], y[2], y[3]]);
            let (own, others) = rest.split_at_mut(NODES - m);
            for (block, qn) in own.iter_mut().zip(&point.slopes[m..]) {
                for k in 0..4 {
                    block[k] += by_x[k] * qn.x + by_y[k] * qn.y;
                }
            }
            rest = others;
        }
    }

    /// The matrix; above the blocks of the diagonal it is zero.
    pub(super) fn stiffness(&self) -> Stiffness {
        let mut stiffness = Stiffness::zeros();
        let mut blocks = self.0.iter();
        for m in 0..NODES {
            for (n, block) in (m..NODES).zip(&mut blocks) {
                // Column by column: `2 m` is the column, `2 n` the row.
                let start = 2 * m * DOFS + 2 * n;
                let entries = stiffness.as_mut_slice();
                entries[start..start + 2].copy_from_slice(&block[..2]);
                entries[start + DOFS..start + DOFS + 2].copy_from_slice(&block[2..]);
            }
        }
        stiffness
    }
}
