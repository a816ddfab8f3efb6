//! Global deformations: a solid inside one deformable block, as [`crate::solid::Global`] has it in the plane.
//!
//! The displacement at a reference place is the triquadratic one of a block of 27 nodes round the solid: 81 parameters,
//! whatever the detail of the solid. For solids far from where they are pushed: a dent of a tip is smeared over the block. The
//! energy is integrated over the solid, not over the block, and the weight likewise; the surface is the solid's.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{Solid, rotated};
use crate::solid::NotMixed;
use crate::space::cells::{Mesh, Share};
use crate::space::element::{BadTable, Dilatation, Point, Table, shape};
use crate::space::law::Material;
use crate::sparse::Triplets;

const NODES: usize = 27;
/// A place may be so far outside the block, in half sides, and moves with it still.
const MARGIN: f64 = 0.5;

/// Why a solid cannot be moved by a block.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoBlock {
    /// The block does not hold the solid, or has no volume.
    #[error("the place {at:?} mm lies outside the block from {low:?} to {high:?} mm, or the block has no volume")]
    Outside {
        /// The first such place.
        at: [f64; 3],
        /// The block's lowest corner.
        low: [f64; 3],
        /// Its highest corner.
        high: [f64; 3],
    },
    /// The solid's points make no element.
    #[error(transparent)]
    Table(#[from] BadTable),
    /// The material.
    #[error(transparent)]
    Material(#[from] NotMixed),
}

/// A point of the surface: place, normal, area and gap, and the weights of the block's nodes.
type SurfacePoint = (Vector3<f64>, Vector3<f64>, [f64; 2], [f64; NODES]);

/// A solid in a deformable block of 27 nodes.
#[derive(Debug, Clone)]
pub struct Global {
    centre: Vector3<f64>,
    half: Vector3<f64>,
    nodes: Vec<Vector3<f64>>,
    table: Table,
    material: Material,
    weights: Vec<f64>,
    surface: Vec<SurfacePoint>,
    extent: f64,
}

impl Global {
    /// The solid of `mesh` in the block between two corners. `weight` is the force on a unit of reference volume.
    ///
    /// # Errors
    /// Every variant of [`NoBlock`].
    pub fn new(
        mesh: &Mesh,
        material: Material,
        weight: Vector3<f64>,
        [low, high]: [Vector3<f64>; 2],
    ) -> Result<Self, NoBlock> {
        NotMixed::check(&material.law, &material.lame, true)?;
        // Negated as a whole: what is not a number is outside too.
        let outside = |p: &Vector3<f64>| !(0..3).all(|k| p[k] >= low[k] && p[k] <= high[k] && low[k] < high[k]);
        let surface = mesh.surface.iter().map(|point| point.at);
        let mut places = mesh.points().iter().map(|point| point.at).chain(surface);
        if let Some(at) = places.find(outside) {
            let [at, low, high] = [at, low, high].map(Into::into);
            return Err(NoBlock::Outside { at, low, high });
        }
        let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let local = |at: &Vector3<f64>| (at - centre).component_div(&half).into();
        let point = |at: &Vector3<f64>, weight: f64| Point {
            weight,
            at: *at,
            slopes: shape::gradients_27(local(at)).map(|q| q.component_div(&half)).to_vec(),
        };
        let points: Vec<Point> = mesh.points().iter().map(|p| point(&p.at, p.volume)).collect();
        let mut weights = vec![0.0; 3 * NODES];
        for point in mesh.points() {
            for (node, value) in shape::values_27(local(&point.at)).into_iter().enumerate() {
                (0..3).for_each(|k| weights[3 * node + k] += weight[k] * point.volume * value);
            }
        }
        let surface = mesh.surface.iter();
        Ok(Self {
            table: Table::new(NODES, &points, Dilatation::Linear)?,
            nodes: (0..NODES).map(|n| centre + half.component_mul(&corner(n))).collect(),
            surface: surface
                .map(|p| (p.at, p.normal, [p.area, p.gap], shape::values_27(local(&p.at))))
                .collect(),
            extent: 2.0 * half.max(),
            centre,
            half,
            material,
            weights,
        })
    }
}

/// A node in the block's own coordinates.
fn corner(node: usize) -> Vector3<f64> {
    Vector3::from([node % 3, node / 3 % 3, node / 9].map(|i| i as f64 - 1.0))
}

impl Solid for Global {
    fn parameters(&self) -> usize {
        3 * NODES
    }

    fn translate(&self, a: &mut [f64], by: Vector3<f64>) {
        for u in a.chunks_exact_mut(3) {
            (0..3).for_each(|k| u[k] += by[k]);
        }
    }

    fn rotate(&self, a: &mut [f64], by: &Rotation3<f64>, centre: Vector3<f64>) {
        rotated(a, &self.nodes, by, centre);
    }

    fn energy(&self, a: &[f64]) -> Option<f64> {
        let weight: f64 = self.weights.iter().zip(a).map(|(w, a)| w * a).sum();
        let energy = self.table.energy(&self.material, a)? - weight;
        Some(energy).filter(|e| e.is_finite())
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let mut energy = self.table.gradient(&self.material, a, gradient)?;
        for ((g, w), a) in gradient.iter_mut().zip(&self.weights).zip(a) {
            *g -= w;
            energy -= w * a;
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        let mut packed = Vec::new();
        self.table.stiffness(&self.material, a, convex, &mut packed)?;
        sink.add_block(offset..offset + 3 * NODES, &packed);
        Some(())
    }

    fn weight(&self, forces: &mut [f64]) {
        forces.iter_mut().zip(&self.weights).for_each(|(f, w)| *f += w);
    }

    fn least_determinant(&self, a: &[f64]) -> f64 {
        self.table.least_determinant(a)
    }

    fn stiffness_scale(&self) -> f64 {
        // By the only cube that there is: a force by length, whatever the unit.
        self.material.lame.confined() * self.extent
    }

    fn shear_scale(&self) -> f64 {
        self.material.lame.mu
    }

    fn extent(&self) -> f64 {
        self.extent
    }

    fn places(&self) -> Vec<[f64; 3]> {
        self.nodes.iter().flat_map(|x| [(*x).into(); 3]).collect()
    }

    fn points(&self) -> usize {
        self.surface.len()
    }

    fn reference(&self, point: usize) -> (Vector3<f64>, Vector3<f64>, f64) {
        let (at, normal, [area, _], _) = self.surface[point];
        (at, normal, area)
    }

    fn gap(&self, point: usize) -> f64 {
        self.surface[point].2[1]
    }

    fn point(&self, a: &[f64], point: usize) -> Vector3<f64> {
        let (at, _, _, weights) = &self.surface[point];
        let moved = weights.iter().zip(a.chunks_exact(3));
        at + moved
            .map(|(w, u)| Vector3::from_column_slice(u) * *w)
            .sum::<Vector3<f64>>()
    }

    fn rows(&self, _a: &[f64], point: usize, visit: &mut dyn FnMut(usize, Vector3<f64>)) {
        for (node, weight) in self.surface[point].3.iter().enumerate() {
            (0..3).for_each(|k| visit(3 * node + k, Vector3::ith(k, *weight)));
        }
    }

    fn shares(&self, at: &Vector3<f64>) -> Option<Vec<Share>> {
        let local: [f64; 3] = (at - self.centre).component_div(&self.half).into();
        if !local.iter().all(|x| x.abs() <= 1.0 + MARGIN) {
            return None;
        }
        let (values, slopes) = (shape::values_27(local), shape::gradients_27(local));
        let curvatures = shape::curvatures_27(local);
        let half = &self.half;
        let share = |node: usize| Share {
            node: node as u32,
            weight: values[node],
            slope: slopes[node].component_div(half),
            curvature: Matrix3::from_fn(|p, q| curvatures[node][(p, q)] / (half[p] * half[q])),
        };
        Some((0..NODES).map(share).collect())
    }
}
