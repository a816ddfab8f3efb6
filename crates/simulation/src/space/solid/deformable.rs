//! Deformable solids: a mesh, a material and a weight. Parameters are the displacements of the free nodes.

use nalgebra::{Rotation3, Vector3};

use super::sums::{Sums, taken};
use super::{Inner, Solid, determinant, rotated, stretched};
use crate::solid::NotMixed;
use crate::space::cells::{Mesh, Share};
use crate::space::law::Material;
use crate::sparse::Triplets;

/// Bounds of determinants end where they are so near to one another, and after so many halvings of whole and of cut cubes.
const NEAR: f64 = 1e-3;
const DEPTH: u32 = 8;
const CUT_DEPTH: u32 = 3;

/// A mesh of one material under a uniform weight.
#[derive(Debug, Clone)]
pub struct Deformable {
    mesh: Mesh,
    material: Material,
    weights: Vec<f64>,
    /// Of each point of the surface its free nodes.
    rows: Vec<Vec<(u32, f64)>>,
    sums: Sums,
    extent: f64,
    /// Side of the largest cube.
    side: f64,
    /// Of each cube whether the surface leaves it alone.
    whole: Vec<bool>,
    /// Of each cube the points of the surface in it, from -1 to 1 along each axis.
    surface: Vec<Vec<[f64; 3]>>,
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
            sums: Sums::new(&mesh),
            surface: mesh.surface_by_cube(),
            whole: mesh.whole_cubes(),
            extent: (high - low).max(),
            side: mesh
                .grid()
                .cells()
                .map(|c| mesh.grid().length(c.span))
                .fold(0.0, f64::max),
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

    /// How many elements are done four at once, and how many one by one: only whole cubes of one size have a table in common.
    pub fn together(&self) -> [usize; 2] {
        self.sums.counts()
    }

    /// Bounds of the least determinant of the deformation gradient at all places of all cubes: it is nowhere less than the first, and is the
    /// second somewhere inside. Where the first is above zero nothing is turned inside out, between the elements' points neither.
    /// Of cubes that the surface cuts all of the cube is bounded, so that the first may lie far below what is inside.
    pub fn bounded_determinant(&self, a: &[f64]) -> (f64, f64) {
        let mut volumes = vec![0.0; self.mesh.cubes().len()];
        self.mesh.points().iter().for_each(|p| volumes[p.cube()] += p.volume);
        let (mut lower, mut reached) = (f64::INFINITY, self.least_determinant(a));
        for (number, (cell, volume)) in self.mesh.cubes().iter().zip(volumes).enumerate() {
            let side = self.mesh.grid().length(cell.span);
            let whole = volume > side.powi(3) * (1.0 - 1e-9);
            let depth = if whole { DEPTH } else { CUT_DEPTH };
            let found = determinant::least(&self.mesh.nodal(number, a), side, NEAR, depth);
            // Corners of cut cubes may be outside.
            reached = if whole { reached.min(found.reached) } else { reached };
            // What is no number stays: such a cube has no bound.
            lower = if lower.is_nan() || found.lower >= lower {
                lower
            } else {
                found.lower
            };
        }
        (lower, reached)
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
        let elastic = self.sums.energy(&self.mesh, &self.material, a)?;
        Some(self.weight_energy(a) + elastic).filter(|e| e.is_finite())
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        gradient.iter_mut().zip(&self.weights).for_each(|(g, w)| *g -= w);
        let elastic = self.sums.gradient(&self.mesh, &self.material, a, gradient)?;
        Some(self.weight_energy(a) + elastic).filter(|e| e.is_finite())
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        self.sums.hessian((&self.mesh, &self.material), a, convex, sink, offset)
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
        // Against shear: what lets a solid move is that, not what keeps its volume, which may be thousands of times as stiff.
        2.0 * self.material.lame.mu * self.side
    }

    fn shear_scale(&self) -> f64 {
        self.material.lame.mu
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

    fn gap(&self, point: usize) -> f64 {
        self.mesh.surface[point].gap
    }

    fn inner(&self) -> Vec<Inner> {
        let points = self.mesh.points().iter();
        let inner = points.map(|point| Inner {
            at: point.at,
            row: self.mesh.point_row(point),
        });
        inner.collect()
    }

    fn is_upright(&self, a: &[f64], near: &dyn Fn(&Vector3<f64>, f64) -> bool) -> bool {
        let mut cubes = self.mesh.cubes().iter().enumerate();
        cubes.all(|(number, cell)| {
            let side = self.mesh.grid().length(cell.span);
            if !near(&self.mesh.middle(number, a), side) {
                return true;
            }
            let u = self.mesh.nodal(number, a);
            match self.mesh.inside(number).filter(|_| !self.whole[number]) {
                None => determinant::is_positive(&u, side, NEAR, CUT_DEPTH),
                // What of a cut cube is outside need not be upright, and often is not, hard by the surface: hardly any material holds it. So no bound serves.
                Some(inside) => {
                    let places = inside.middles().chain(self.surface[number].iter().copied());
                    determinant::is_positive_at(&u, side, places)
                }
            }
        })
    }

    fn stretch(&self, a: &[f64], point: usize) -> f64 {
        let point = &self.mesh.surface[point];
        stretched(&point.normal, self.mesh.surface_slopes(point), a)
    }

    fn point(&self, a: &[f64], point: usize) -> Vector3<f64> {
        let mut at = self.mesh.surface[point].at;
        for (node, weight) in &self.rows[point] {
            (0..3).for_each(|k| at[k] += weight * a[3 * *node as usize + k]);
        }
        at
    }

    fn combination(&self, point: usize) -> Option<&[(u32, f64)]> {
        Some(&self.rows[point])
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
