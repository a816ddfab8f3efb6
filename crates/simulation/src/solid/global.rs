//! Global deformations: a solid inside a deformable block (II 3.6).
//!
//! The displacement at a reference point is the biquadratic one of a rectangular block of nine nodes round the solid: 18
//! parameters, whatever the detail of the solid. For moderately stiff solids. The energy is integrated over the solid,
//! not over the block, and the weight likewise.

use nalgebra::{Matrix2, Vector2};

use super::deformable::{add_stiffness, turned};
use super::{Boundary, Solid};
use crate::law::Material;
use crate::q9::blocks::{DOFS, Forces};
use crate::q9::element::Element;
use crate::q9::field::interpolated;
use crate::q9::{FieldPoint, GaussPoint, Mesh, NODES, gradients, values};
use crate::sparse::Triplets;

/// The block does not hold the solid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("node {node} at ({x}, {y}) lies outside the block from ({x0}, {y0}) to ({x1}, {y1}), or the block has no area")]
pub struct OutsideBlock {
    /// The first such node.
    pub node: usize,
    /// Where it lies.
    pub x: f64,
    /// Where it lies.
    pub y: f64,
    /// The block's corner.
    pub x0: f64,
    /// The block's corner.
    pub y0: f64,
    /// The block's far corner.
    pub x1: f64,
    /// The block's far corner.
    pub y1: f64,
}

/// A solid in a deformable block of nine nodes.
#[derive(Debug, Clone)]
pub struct Global {
    mesh: Mesh,
    material: Material,
    weight: Vector2<f64>,
    block: Element,
    /// Reference positions of the block's nodes.
    nodes: [Vector2<f64>; NODES],
    boundary: Boundary,
    /// Weights of the block's nodes at each node of the mesh.
    shares: Vec<[f64; NODES]>,
}

impl Global {
    /// The solid of `mesh` in the block from `low` to `high`. `weight` is the force on a unit of reference area.
    ///
    /// # Errors
    /// [`OutsideBlock`].
    pub fn new(
        mesh: Mesh,
        material: Material,
        weight: Vector2<f64>,
        [low, high]: [Vector2<f64>; 2],
    ) -> Result<Self, OutsideBlock> {
        // Negated as a whole: a NaN is outside too.
        let outside = |p: &Vector2<f64>| !(p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y);
        // A block without area has no coordinates inside it.
        let area = (high - low).min() > 0.0;
        let first = if area {
            mesh.nodes.iter().position(outside)
        } else {
            Some(0)
        };
        if let Some(node) = first {
            let at = mesh.nodes[node];
            let [[x, y], [x0, y0], [x1, y1]] = [at, low, high].map(|p| [p.x, p.y]);
            return Err(OutsideBlock {
                node,
                x,
                y,
                x0,
                y0,
                x1,
                y1,
            });
        }
        let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let local = |p: Vector2<f64>| (p - centre).component_div(&half);
        let nodes = std::array::from_fn(|n| {
            centre + half.component_mul(&Vector2::new((n % 3) as f64 - 1.0, (n / 3) as f64 - 1.0))
        });
        let block = block(&mesh, half, local);
        let shares = mesh.nodes.iter().map(|p| values(local(*p).x, local(*p).y)).collect();
        let boundary = Boundary::new(mesh.boundary.clone(), |n| mesh.nodes[n]);
        Ok(Self {
            mesh,
            material,
            weight,
            block,
            nodes,
            boundary,
            shares,
        })
    }

    /// The mesh of the solid in the block.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    fn displacement(&self, a: &[f64], node: usize) -> Vector2<f64> {
        let parts = self.shares[node].iter().enumerate();
        parts.map(|(n, w)| Vector2::new(a[2 * n], a[2 * n + 1]) * *w).sum()
    }
}

/// One element of nine nodes whose Gauss points are those of the whole mesh.
fn block(mesh: &Mesh, half: Vector2<f64>, local: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Element {
    let mut points = Vec::with_capacity(9 * mesh.elements.len());
    for (k, element) in mesh.elements.iter().enumerate() {
        let corners = mesh.corners(k);
        for point in &element.points {
            let at: Vector2<f64> = corners.iter().zip(point.values).map(|(c, w)| c * w).sum();
            let x = local(at);
            points.push(GaussPoint {
                weight: point.weight,
                values: values(x.x, x.y),
                // The block's map is `centre + half * (u, v)`: its inverse divides by the half sides.
                slopes: gradients(x.x, x.y).map(|g| g.component_div(&half)),
                local: [x.x, x.y],
            });
        }
    }
    Element::of_points(std::array::from_fn(|n| n), points)
}

impl Solid for Global {
    fn parameters(&self) -> usize {
        DOFS
    }

    fn translate(&self, a: &mut [f64], by: Vector2<f64>) {
        for u in a.chunks_exact_mut(2) {
            u[0] += by.x;
            u[1] += by.y;
        }
    }

    fn rotate(&self, a: &mut [f64], angle: f64, centre: Vector2<f64>) {
        for (u, reference) in a.chunks_exact_mut(2).zip(&self.nodes) {
            let by = turned(reference + Vector2::new(u[0], u[1]) - centre, angle);
            u[0] += by.x;
            u[1] += by.y;
        }
    }

    fn energy(&self, a: &[f64]) -> Option<f64> {
        let elastic = self.block.energy(&self.material, &self.block.displacements(a))?;
        let mut forces = [0.0; DOFS];
        self.weight(&mut forces);
        let weight: f64 = forces.iter().zip(a).map(|(f, a)| f * a).sum();
        Some(elastic - weight).filter(|e| e.is_finite())
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let mut forces = Forces::zeros();
        let elastic = self
            .block
            .gradient(&self.material, &self.block.displacements(a), &mut forces)?;
        let mut weight = [0.0; DOFS];
        self.weight(&mut weight);
        let mut energy = elastic;
        for k in 0..DOFS {
            gradient[k] += forces[k] - weight[k];
            energy -= weight[k] * a[k];
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        let stiffness = self
            .block
            .stiffness(&self.material, &self.block.displacements(a), convex)?;
        add_stiffness(sink, &stiffness, |p| offset + p);
        Some(())
    }

    fn weight(&self, forces: &mut [f64]) {
        for point in &self.block.points {
            for (n, value) in point.values.iter().enumerate() {
                forces[2 * n] += self.weight.x * point.weight * value;
                forces[2 * n + 1] += self.weight.y * point.weight * value;
            }
        }
    }

    fn least_determinant(&self, a: &[f64]) -> f64 {
        let u = self.block.displacements(a);
        let determinant = |p: &GaussPoint| (Matrix2::identity() + p.gradient(&u)).determinant();
        self.block.points.iter().map(determinant).fold(f64::INFINITY, f64::min)
    }

    fn stiffness_scale(&self) -> f64 {
        self.material.lame.confined()
    }

    fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    fn point(&self, a: &[f64], node: usize) -> Vector2<f64> {
        self.mesh.nodes[node] + self.displacement(a, node)
    }

    fn point_about(&self, a: &[f64], node: usize, origin: Vector2<f64>) -> Vector2<f64> {
        (self.mesh.nodes[node] - origin) + self.displacement(a, node)
    }

    fn rows(&self, _a: &[f64], node: usize, visit: &mut dyn FnMut(usize, Vector2<f64>)) {
        for (n, w) in self.shares[node].iter().enumerate() {
            visit(2 * n, Vector2::new(*w, 0.0));
            visit(2 * n + 1, Vector2::new(0.0, *w));
        }
    }

    fn patches(&self) -> usize {
        self.mesh.elements.len()
    }

    /// The gradient is that of the block; the position follows the nodes of the solid, as its boundary does.
    fn field(&self, a: &[f64], patch: usize, at: [f64; 2]) -> Option<FieldPoint> {
        let element = self.mesh.elements.get(patch)?;
        let reference = interpolated(&self.mesh.corners(patch), at);
        let place = |n: usize| self.point(a, n);
        let (low, high) = (self.nodes[0], self.nodes[NODES - 1]);
        let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let local = (reference - centre).component_div(&half);
        let gradient = GaussPoint::of(&self.nodes, [local.x, local.y], 1.0)?.gradient(&self.block.displacements(a));
        Some(FieldPoint {
            position: interpolated(&element.nodes.map(place), at),
            gradient,
            state: self.material.state(&gradient, None),
        })
    }
}
