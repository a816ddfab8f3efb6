//! A Gauss point of an element in its reference configuration.

use nalgebra::{Matrix2, Vector2};

use super::{NODES, gradients, values};

/// Weight and shape functions at one point of the reference configuration.
#[derive(Debug, Clone, Copy)]
pub struct GaussPoint {
    /// Area that the point stands for.
    pub weight: f64,
    /// Weights of the nodes.
    pub values: [f64; NODES],
    /// Their derivatives by the reference position, `Q_n` (II 3.8).
    pub slopes: [Vector2<f64>; NODES],
    /// Local coordinates.
    pub local: [f64; 2],
}

/// The Jacobian matrix of the reference map at `(u, v)`, column by column `dR/du`, `dR/dv`.
pub(super) fn map(nodes: &[Vector2<f64>; NODES], u: f64, v: f64) -> Matrix2<f64> {
    let mut map = Matrix2::zeros();
    for (node, slope) in nodes.iter().zip(gradients(u, v)) {
        map += node * slope.transpose();
    }
    map
}

impl GaussPoint {
    /// The point `(u, v)` of the rule's weight `weight`. `None` where the map is singular.
    pub(crate) fn of(nodes: &[Vector2<f64>; NODES], [u, v]: [f64; 2], weight: f64) -> Option<Self> {
        let map = map(nodes, u, v);
        // Gradients transform by the inverse transpose of the map.
        let inverse = map.try_inverse()?.transpose();
        Some(Self {
            weight: weight * map.determinant(),
            values: values(u, v),
            slopes: gradients(u, v).map(|g| inverse * g),
            local: [u, v],
        })
    }

    /// The displacement gradient `G = sum_n u_n Q_n^T` of nodal displacements.
    #[inline]
    pub fn gradient(&self, displacements: &[Vector2<f64>; NODES]) -> Matrix2<f64> {
        let mut g = Matrix2::zeros();
        for (u, q) in displacements.iter().zip(&self.slopes) {
            g += u * q.transpose();
        }
        g
    }
}
