//! A deformable solid whose sums run element by element, and whose points tell nothing of their nodes.

use nalgebra::{Rotation3, Vector3};
use simulation::space::lanes::Lanes;
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::sparse::Triplets;

/// See the module.
#[derive(Debug)]
pub(crate) struct OneByOne {
    pub(crate) solid: Deformable,
    pub(crate) material: Material,
}

fn taken(nodes: &[u32], a: &[f64], u: &mut Vec<f64>) {
    u.clear();
    for node in nodes {
        u.extend_from_slice(&a[3 * *node as usize..3 * *node as usize + 3]);
    }
}

impl Solid for OneByOne {
    fn energy(&self, a: &[f64]) -> Option<f64> {
        let (mut energy, mut u, mut lanes) = (0.0, Vec::new(), Lanes::new());
        for element in &self.solid.mesh().elements {
            taken(&element.nodes, a, &mut u);
            energy += lanes.energy_of_one(self.solid.mesh().table(element), &self.material, &u)?;
        }
        Some(energy)
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (mut energy, mut u, mut forces, mut lanes) = (0.0, Vec::new(), Vec::new(), Lanes::new());
        for element in &self.solid.mesh().elements {
            taken(&element.nodes, a, &mut u);
            forces.clear();
            forces.resize(u.len(), 0.0);
            energy += lanes.gradient_of_one(self.solid.mesh().table(element), &self.material, &u, &mut forces)?;
            for (node, force) in element.nodes.iter().zip(forces.chunks_exact(3)) {
                (0..3).for_each(|k| gradient[3 * *node as usize + k] += force[k]);
            }
        }
        Some(energy)
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        let (mut u, mut packed, mut lanes) = (Vec::new(), Vec::new(), Lanes::new());
        for element in &self.solid.mesh().elements {
            taken(&element.nodes, a, &mut u);
            let table = self.solid.mesh().table(element);
            lanes
                .stiffness_of_one(table, &self.material, &u, convex, &mut packed)
                .then_some(())?;
            sink.add_block(
                (0..u.len()).map(|p| offset + 3 * element.nodes[p / 3] as usize + p % 3),
                &packed,
            );
        }
        Some(())
    }

    fn parameters(&self) -> usize {
        self.solid.parameters()
    }

    fn translate(&self, a: &mut [f64], by: Vector3<f64>) {
        self.solid.translate(a, by);
    }

    fn rotate(&self, a: &mut [f64], by: &Rotation3<f64>, centre: Vector3<f64>) {
        self.solid.rotate(a, by, centre);
    }

    fn weight(&self, forces: &mut [f64]) {
        self.solid.weight(forces);
    }

    fn least_determinant(&self, a: &[f64]) -> f64 {
        self.solid.least_determinant(a)
    }

    fn stiffness_scale(&self) -> f64 {
        self.solid.stiffness_scale()
    }

    fn extent(&self) -> f64 {
        self.solid.extent()
    }

    fn places(&self) -> Vec<[f64; 3]> {
        self.solid.places()
    }

    fn points(&self) -> usize {
        self.solid.points()
    }

    fn reference(&self, point: usize) -> (Vector3<f64>, Vector3<f64>, f64) {
        self.solid.reference(point)
    }

    fn point(&self, a: &[f64], point: usize) -> Vector3<f64> {
        self.solid.point(a, point)
    }

    fn rows(&self, a: &[f64], point: usize, visit: &mut dyn FnMut(usize, Vector3<f64>)) {
        self.solid.rows(a, point, visit);
    }
}
