//! Deformable solids: a mesh, a material and a weight. Parameters are the displacements of the nodes.

use nalgebra::Vector2;

use super::{Boundary, Solid};
use crate::law::{Lame, Law, Material};
use crate::q9::blocks::{DOFS, Forces, Stiffness};
use crate::q9::{FieldPoint, Mesh};
use crate::sparse::Triplets;

/// From this ratio on, plain elements lock and their Newton steps fail: the mixed form is asked for.
const MIXED_FROM: f64 = 0.495;

/// A nearly incompressible material on plain elements.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("Poisson's ratio {poisson} with plain elements: from {MIXED_FROM} on they lock; use the mixed form")]
pub struct NotMixed {
    /// The ratio.
    pub poisson: f64,
}

impl NotMixed {
    /// Refuses a nearly incompressible material on elements that are not mixed.
    pub(crate) fn check(law: &Law, lame: &Lame, mixed: bool) -> Result<(), Self> {
        // `nu = lambda / (2 (lambda + mu))`.
        let poisson = 0.5 * lame.lambda / (lame.lambda + lame.mu);
        // These two have an energy everywhere: locking makes them wrong, not unsolvable.
        let finite = matches!(law, Law::Linear | Law::StVenantKirchhoff);
        if poisson >= MIXED_FROM && !mixed && !finite {
            return Err(Self { poisson });
        }
        Ok(())
    }
}

/// A mesh of one material under a uniform weight.
#[derive(Debug, Clone)]
pub struct Deformable {
    mesh: Mesh,
    material: Material,
    /// Forces of the weight on the parameters.
    weights: Vec<f64>,
    boundary: Boundary,
}

impl Deformable {
    /// A solid of this mesh and material. `weight` is the force on a unit of reference area, density times gravity.
    ///
    /// # Errors
    /// [`NotMixed`]. Linear and Saint Venant-Kirchhoff materials of any ratio are let through on plain elements, so that
    /// the locking can be measured.
    pub fn new(mesh: Mesh, material: Material, weight: Vector2<f64>) -> Result<Self, NotMixed> {
        NotMixed::check(&material.law, &material.lame, mesh.is_mixed())?;
        let boundary = Boundary::new(mesh.boundary.clone(), |n| mesh.nodes[n]);
        let weights = weights(&mesh, weight);
        Ok(Self {
            weights,
            mesh,
            material,
            boundary,
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    fn weight_energy(&self, a: &[f64]) -> f64 {
        -self.weights.iter().zip(a).map(|(w, a)| w * a).sum::<f64>()
    }
}

/// The forces of a weight by reference area on the nodes of a mesh.
fn weights(mesh: &Mesh, weight: Vector2<f64>) -> Vec<f64> {
    let mut forces = vec![0.0; 2 * mesh.nodes.len()];
    for element in &mesh.elements {
        for point in &element.points {
            for (node, value) in element.nodes.iter().zip(point.values) {
                forces[2 * node] += weight.x * point.weight * value;
                forces[2 * node + 1] += weight.y * point.weight * value;
            }
        }
    }
    forces
}

impl Solid for Deformable {
    fn parameters(&self) -> usize {
        2 * self.mesh.nodes.len()
    }

    fn translate(&self, a: &mut [f64], by: Vector2<f64>) {
        for u in a.chunks_exact_mut(2) {
            u[0] += by.x;
            u[1] += by.y;
        }
    }

    fn rotate(&self, a: &mut [f64], angle: f64, centre: Vector2<f64>) {
        for (u, reference) in a.chunks_exact_mut(2).zip(&self.mesh.nodes) {
            let at = reference + Vector2::new(u[0], u[1]) - centre;
            let by = turned(at, angle);
            u[0] += by.x;
            u[1] += by.y;
        }
    }

    fn energy(&self, a: &[f64]) -> Option<f64> {
        let mut energy = self.weight_energy(a);
        for element in &self.mesh.elements {
            energy += element.energy(&self.material, &element.displacements(a))?;
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let mut energy = self.weight_energy(a);
        gradient.iter_mut().zip(&self.weights).for_each(|(g, w)| *g -= w);
        for element in &self.mesh.elements {
            let mut forces = Forces::zeros();
            energy += element.gradient(&self.material, &element.displacements(a), &mut forces)?;
            for (n, node) in element.nodes.iter().enumerate() {
                gradient[2 * node] += forces[2 * n];
                gradient[2 * node + 1] += forces[2 * n + 1];
            }
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        for element in &self.mesh.elements {
            let stiffness = element.stiffness(&self.material, &element.displacements(a), convex)?;
            add_stiffness(sink, &stiffness, |p| offset + 2 * element.nodes[p / 2] + p % 2);
        }
        Some(())
    }

    fn weight(&self, forces: &mut [f64]) {
        forces.iter_mut().zip(&self.weights).for_each(|(f, w)| *f += w);
    }

    fn least_determinant(&self, a: &[f64]) -> f64 {
        let elements = self.mesh.elements.iter().enumerate();
        elements
            .map(|(k, e)| e.least_determinant(&self.mesh.corners(k), &e.displacements(a)))
            .fold(f64::INFINITY, f64::min)
    }

    fn stiffness_scale(&self) -> f64 {
        self.material.lame.confined()
    }

    fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    fn point(&self, a: &[f64], node: usize) -> Vector2<f64> {
        self.mesh.nodes[node] + Vector2::new(a[2 * node], a[2 * node + 1])
    }

    fn point_about(&self, a: &[f64], node: usize, origin: Vector2<f64>) -> Vector2<f64> {
        (self.mesh.nodes[node] - origin) + Vector2::new(a[2 * node], a[2 * node + 1])
    }

    fn rows(&self, _a: &[f64], node: usize, visit: &mut dyn FnMut(usize, Vector2<f64>)) {
        visit(2 * node, Vector2::x());
        visit(2 * node + 1, Vector2::y());
    }

    fn own(&self, node: usize) -> Option<usize> {
        Some(2 * node)
    }

    fn patches(&self) -> usize {
        self.mesh.elements.len()
    }

    fn field(&self, a: &[f64], patch: usize, at: [f64; 2]) -> Option<FieldPoint> {
        self.mesh.field(patch, &self.material, a, at)
    }
}

/// Adds the lower triangle of an element's stiffness, its degrees of freedom being these unknowns.
pub(super) fn add_stiffness(sink: &mut Triplets, stiffness: &Stiffness, unknown: impl Fn(usize) -> usize + Clone) {
    let (mut values, mut count) = ([0.0; DOFS * (DOFS + 1) / 2], 0);
    let entries = stiffness.as_slice();
    for p in 0..DOFS {
        // Element matrices are filled below the diagonal only: entry `(p, q)` with `p >= q`.
        for q in 0..=p {
            values[count] = entries[q * DOFS + p];
            count += 1;
        }
    }
    sink.add_block((0..DOFS).map(unknown), &values);
}

/// How far a point at `at` from the centre moves when it turns: `(R - I) at`, exact for small angles too.
pub(super) fn turned(at: Vector2<f64>, angle: f64) -> Vector2<f64> {
    // `cos - 1` without its cancellation.
    let less = -2.0 * (0.5 * angle).sin().powi(2);
    let sin = angle.sin();
    Vector2::new(less * at.x - sin * at.y, sin * at.x + less * at.y)
}
