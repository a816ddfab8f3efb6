//! Energy, forces and stiffness of one element.

use nalgebra::{Matrix2, Matrix4, SMatrix, SVector, Vector2, Vector4};

use super::mixed::Pressure;
use super::{GaussPoint, NODES};
use crate::law::Material;

/// Degrees of freedom: `(x, y)` of node 0, of node 1, ...
pub(crate) const DOFS: usize = 2 * NODES;

/// The stiffness of an element.
pub(crate) type Stiffness = SMatrix<f64, DOFS, DOFS>;
/// The forces on its nodes.
pub(crate) type Forces = SVector<f64, DOFS>;

/// An element: its nodes, and its Gauss points in the reference configuration.
#[derive(Debug, Clone)]
pub struct Element {
    /// Nodes of the mesh.
    pub nodes: [usize; NODES],
    /// Its Gauss points: nine in an element of a mesh, more in the block of a global deformation.
    pub points: Vec<GaussPoint>,
    /// The pressures of the mixed form, where it is asked for.
    pub(super) pressure: Option<Pressure>,
}

impl Element {
    /// An element of these nodes and Gauss points, without pressures.
    pub(crate) fn of_points(nodes: [usize; NODES], points: Vec<GaussPoint>) -> Self {
        Self {
            nodes,
            points,
            pressure: None,
        }
    }

    /// The displacements of its nodes out of the mesh's parameters.
    #[inline]
    pub(crate) fn displacements(&self, a: &[f64]) -> [Vector2<f64>; NODES] {
        self.nodes.map(|n| Vector2::new(a[2 * n], a[2 * n + 1]))
    }

    /// The elastic energy. `None` where the law has none.
    pub(crate) fn energy(&self, material: &Material, u: &[Vector2<f64>; NODES]) -> Option<f64> {
        if let Some(pressure) = &self.pressure {
            return pressure.energy(self, material, u);
        }
        let mut energy = 0.0;
        for point in &self.points {
            energy += point.weight * material.density(&point.gradient(u))?;
        }
        Some(energy)
    }

    /// The elastic energy, and its derivatives added to `forces`.
    pub(crate) fn gradient(&self, material: &Material, u: &[Vector2<f64>; NODES], forces: &mut Forces) -> Option<f64> {
        if let Some(pressure) = &self.pressure {
            return pressure.gradient(self, material, u, forces);
        }
        let mut energy = 0.0;
        for point in &self.points {
            let (density, stress) = material.stress(&point.gradient(u))?;
            energy += point.weight * density;
            add_forces(point, &stress, forces);
        }
        Some(energy)
    }

    /// The second derivative of the elastic energy; where `convex`, of the nearest convex tangents.
    pub(crate) fn stiffness(&self, material: &Material, u: &[Vector2<f64>; NODES], convex: bool) -> Option<Stiffness> {
        if let Some(pressure) = &self.pressure {
            return pressure.stiffness(self, material, u, convex);
        }
        let mut blocks = Blocks::default();
        for point in &self.points {
            let g = point.gradient(u);
            let tangent = material.tangent(&g)?;
            blocks.add(point, &clamped(material, tangent, &g, convex));
        }
        Some(blocks.stiffness())
    }

    /// The least `det F` of its Gauss points, and of a 5 x 5 grid up to its corners: a sample, no bound.
    pub(crate) fn least_determinant(&self, reference: &[Vector2<f64>; NODES], u: &[Vector2<f64>; NODES]) -> f64 {
        let mut least = f64::INFINITY;
        for k in 0..25 {
            let at = [(k % 5) as f64 * 0.5 - 1.0, (k / 5) as f64 * 0.5 - 1.0];
            if let Some(point) = GaussPoint::of(reference, at, 1.0) {
                least = least.min((Matrix2::identity() + point.gradient(u)).determinant());
            }
        }
        for point in &self.points {
            least = least.min((Matrix2::identity() + point.gradient(u)).determinant());
        }
        least
    }
}

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
                let start = 2 * m * DOFS + 2 * n;
                let entries = stiffness.as_mut_slice();
                entries[start..start + 2].copy_from_slice(&block[..2]);
                entries[start + DOFS..start + DOFS + 2].copy_from_slice(&block[2..]);
            }
        }
        stiffness
    }
}
