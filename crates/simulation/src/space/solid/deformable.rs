//! Deformable solids: a mesh, a material and a weight. Parameters are the displacements of the free nodes.

use nalgebra::{Rotation3, Vector3};

use super::{Solid, rotated};
use crate::solid::NotMixed;
use crate::space::cells::{Mesh, Share};
use crate::space::lanes::Lanes;
use crate::space::law::Material;
use crate::sparse::Triplets;

/// A mesh of one material under a uniform weight.
#[derive(Debug, Clone)]
pub struct Deformable {
    mesh: Mesh,
    material: Material,
    weights: Vec<f64>,
    /// Of each point of the surface its free nodes.
    rows: Vec<Vec<(u32, f64)>>,
    extent: f64,
}

impl Deformable {
    /// A solid of this mesh and material. `weight` is the force on a unit of reference volume, density times gravity.
    ///
    /// # Errors
    /// [`NotMixed`]. Linear and Saint Venant-Kirchhoff materials of any ratio are let through on plain elements, so that
    /// the locking can be measured.
    pub fn new(mesh: Mesh, material: Material, weight: Vector3<f64>) -> Result<Self, NotMixed> {
        NotMixed::check(&material.law, &material.lame, mesh.is_mixed())?;
        let (low, high) = mesh.nodes.iter().fold(
            (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)),
            |(low, high), x| (low.inf(x), high.sup(x)),
        );
        // Dead: in the reference configuration, once.
        let forces = mesh.spread(|_| weight);
        Ok(Self {
            weights: forces,
            rows: mesh.surface.iter().map(|p| mesh.surface_row(p)).collect(),
            extent: (high - low).max(),
            mesh,
            material,
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

    /// Forces on the parameters of a dead load by reference area, on points of the surface, given by their place and normal.
    pub fn traction(&self, traction: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>) -> Vec<(usize, f64)> {
        let mut forces = vec![0.0; self.parameters()];
        for (point, row) in self.mesh.surface.iter().zip(&self.rows) {
            let force = traction(&point.at, &point.normal) * point.area;
            for (node, weight) in row {
                (0..3).for_each(|k| forces[3 * *node as usize + k] += weight * force[k]);
            }
        }
        forces.into_iter().enumerate().filter(|(_, f)| *f != 0.0).collect()
    }

    fn weight_energy(&self, a: &[f64]) -> f64 {
        -self.weights.iter().zip(a).map(|(w, a)| w * a).sum::<f64>()
    }
}

/// The displacements of an element's nodes.
fn taken(nodes: &[u32], a: &[f64], u: &mut Vec<f64>) {
    u.clear();
    for node in nodes {
        u.extend_from_slice(&a[3 * *node as usize..3 * *node as usize + 3]);
    }
}

impl Solid for Deformable {
    fn parameters(&self) -> usize {
        self.mesh.unknowns()
    }

    fn translate(&self, a: &mut [f64], by: Vector3<f64>) {
        for u in a.chunks_exact_mut(3) {
            (0..3).for_each(|k| u[k] += by[k]);
        }
    }

    fn rotate(&self, a: &mut [f64], by: &Rotation3<f64>, centre: Vector3<f64>) {
        rotated(a, &self.mesh.nodes, by, centre);
    }

    fn energy(&self, a: &[f64]) -> Option<f64> {
        let (mut energy, mut u, mut lanes) = (self.weight_energy(a), Vec::new(), Lanes::new());
        for element in &self.mesh.elements {
            taken(&element.nodes, a, &mut u);
            energy += lanes.energy_of_one(self.mesh.table(element), &self.material, &u)?;
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (mut energy, mut u, mut forces) = (self.weight_energy(a), Vec::new(), Vec::new());
        let mut lanes = Lanes::new();
        gradient.iter_mut().zip(&self.weights).for_each(|(g, w)| *g -= w);
        for element in &self.mesh.elements {
            taken(&element.nodes, a, &mut u);
            forces.clear();
            forces.resize(u.len(), 0.0);
            energy += lanes.gradient_of_one(self.mesh.table(element), &self.material, &u, &mut forces)?;
            for (node, force) in element.nodes.iter().zip(forces.chunks_exact(3)) {
                (0..3).for_each(|k| gradient[3 * *node as usize + k] += force[k]);
            }
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        let (mut u, mut packed, mut lanes) = (Vec::new(), Vec::new(), Lanes::new());
        for element in &self.mesh.elements {
            taken(&element.nodes, a, &mut u);
            let table = self.mesh.table(element);
            if !lanes.stiffness_of_one(table, &self.material, &u, convex, &mut packed) {
                return None;
            }
            let unknown = |p: usize| offset + 3 * element.nodes[p / 3] as usize + p % 3;
            sink.add_block((0..u.len()).map(unknown), &packed);
        }
        Some(())
    }

    fn weight(&self, forces: &mut [f64]) {
        forces.iter_mut().zip(&self.weights).for_each(|(f, w)| *f += w);
    }

    fn least_determinant(&self, a: &[f64]) -> f64 {
        let mut u = Vec::new();
        let mut least = f64::INFINITY;
        for element in &self.mesh.elements {
            taken(&element.nodes, a, &mut u);
            least = least.min(self.mesh.table(element).least_determinant(&u));
        }
        least
    }

    fn stiffness_scale(&self) -> f64 {
        self.material.lame.confined()
    }

    fn extent(&self) -> f64 {
        self.extent
    }

    fn places(&self) -> Vec<[f64; 3]> {
        self.mesh.nodes.iter().flat_map(|x| [(*x).into(); 3]).collect()
    }

    fn points(&self) -> usize {
        self.rows.len()
    }

    fn reference(&self, point: usize) -> (Vector3<f64>, Vector3<f64>, f64) {
        let point = &self.mesh.surface[point];
        (point.at, point.normal, point.area)
    }

    fn point(&self, a: &[f64], point: usize) -> Vector3<f64> {
        let mut at = self.mesh.surface[point].at;
        for (node, weight) in &self.rows[point] {
            (0..3).for_each(|k| at[k] += weight * a[3 * *node as usize + k]);
        }
        at
    }

    fn rows(&self, _a: &[f64], point: usize, visit: &mut dyn FnMut(usize, Vector3<f64>)) {
        for (node, weight) in &self.rows[point] {
            for k in 0..3 {
                let mut by = Vector3::zeros();
                by[k] = *weight;
                visit(3 * *node as usize + k, by);
            }
        }
    }

    fn shares(&self, at: &Vector3<f64>) -> Option<Vec<Share>> {
        self.mesh.shares(at)
    }
}
