//! Energy, forces and stiffness of one element.

use nalgebra::{Matrix2, Vector2};

use super::blocks::{Blocks, Forces, Stiffness, add_forces, clamped};
use super::mixed::Pressure;
use super::{GaussPoint, NODES};
use crate::law::Material;

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
            return pressure.energy(&self.points, material, u);
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
            return pressure.gradient(&self.points, material, u, forces);
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
            return pressure.stiffness(&self.points, material, u, convex);
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
        // Elements may fold at their corners, where no Gauss point lies.
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
