//! Oriented particles: a solid moved by points inside it, each with a place and a frame of its own.
//!
//! The thesis (II 2.2.2, 3.2) takes them from Szeliski and Tonnesen (1992) as one of its representations, and leaves them: their energy needs either the
//! neighbourhoods of the particles or one deformation that all of them determine. Here it is the second: each particle carries a displacement and a frame
//! that turns and stretches, 12 unknowns, and its neighbours' affine motions are blended by smooth shares of its place ([`Field`]). The law is integrated
//! over the solid at the points of a mesh of it, whose cubes have dilatations of their own. Positions are linear in the unknowns.
//!
//! Particles need no mesh that fits the shape, and may lie anywhere; but 8 and more of them, 100 unknowns, move each point. `docs/solids-3d.md` has what that costs.

mod field;

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{Inner, Solid, stretched};
use crate::solid::NotMixed;
use crate::space::cells::{Mesh, Share, VolumePoint};
use crate::space::element::{BadTable, Point, Table};
use crate::space::law::Material;
use crate::sparse::Triplets;
use field::{Field, VECTORS};

/// Unknowns of a particle: its displacement, then by what the ends of three axes of its radius move against it, mm.
const UNKNOWNS: usize = 3 * VECTORS;

/// A particle in the reference configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particle {
    /// Where it is, mm. It may lie outside the solid.
    pub at: Vector3<f64>,
    /// How far it moves its surroundings, mm.
    pub radius: f64,
}

impl Particle {
    /// One in the middle of each cube of a mesh, with a radius of so many of its sides. Kernels cover the cubes from 0.9 on; from 1.2 to 1.5 on
    /// some eight reach each place.
    pub fn of_cubes(mesh: &Mesh, radius: f64) -> Vec<Self> {
        let grid = mesh.grid();
        let of = |cell| {
            let [low, high] = grid.corners(cell);
            Self {
                at: (low + high) * 0.5,
                radius: radius * grid.length(cell.span),
            }
        };
        mesh.cubes().iter().map(of).collect()
    }
}

/// Why particles move no solid. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoParticles {
    /// A place that is not finite, or a radius that is not above 0.
    #[error("particle {particle} has a place that is not finite, or a radius that is not a finite number above 0")]
    Particle {
        /// The particle.
        particle: usize,
    },
    /// A place of the solid that no particle reaches, or that only the rims of some do.
    #[error(
        "no particle reaches the place {at:?} mm of the solid, or only the rim of one does: more particles, or larger radii"
    )]
    Uncovered {
        /// The first such place.
        at: [f64; 3],
    },
    /// A particle that moves none of the solid's points.
    #[error("particle {particle} moves nothing of the solid")]
    Idle {
        /// The particle.
        particle: usize,
    },
    /// The points of a cube make no element: too many particles reach it.
    #[error(transparent)]
    Table(#[from] BadTable),
    /// The material.
    #[error(transparent)]
    Material(#[from] NotMixed),
}

/// A cube of the mesh: which vectors of unknowns move it, and how.
#[derive(Debug, Clone)]
struct Part {
    vectors: Vec<u32>,
    table: Table,
}

/// A point of the surface, and which vectors move it.
#[derive(Debug, Clone)]
struct SurfacePoint {
    at: Vector3<f64>,
    normal: Vector3<f64>,
    area: f64,
    gap: f64,
    row: Vec<(u32, f64)>,
    slopes: Vec<(u32, Vector3<f64>)>,
}

/// A solid that particles move.
#[derive(Debug, Clone)]
pub struct Particles {
    field: Field,
    parts: Vec<Part>,
    material: Material,
    weights: Vec<f64>,
    surface: Vec<SurfacePoint>,
    inner: Vec<Inner>,
    extent: f64,
}

impl Particles {
    /// The solid of `mesh`, by whose points energy is integrated and whose surface it has. `weight` is the force on a unit of reference volume.
    /// Shares are no polynomials, and are integrated the better the smaller the cubes: of cubes as large as the particles' distance a uniform strain of
    /// 0.1 is off by 1 % of it, of half as large ones by 0.03 %.
    ///
    /// # Errors
    /// Every variant of [`NoParticles`].
    pub fn new(
        mesh: &Mesh,
        material: Material,
        weight: Vector3<f64>,
        particles: &[Particle],
    ) -> Result<Self, NoParticles> {
        NotMixed::check(&material.law, &material.lame, mesh.is_mixed())?;
        let field = Field::new(particles)?;
        // why all points at once: what moves a place depends on where particles are, never on the state.
        let mut solid = Self {
            weights: vec![0.0; UNKNOWNS * particles.len()],
            parts: Vec::new(),
            surface: Vec::new(),
            inner: Vec::new(),
            extent: extent(
                mesh.surface
                    .iter()
                    .map(|p| p.at)
                    .chain(mesh.points().iter().map(|p| p.at)),
            ),
            field,
            material,
        };
        // Cubes with next to nothing in them go with their neighbours: alone they would have dilatations of next to no volume.
        for (_, points) in mesh.parts() {
            let part = solid.part(&points, mesh, &weight)?;
            solid.parts.push(part);
        }
        for point in &mesh.surface {
            let shares = solid.shares_of(&point.at)?;
            solid.surface.push(SurfacePoint {
                at: point.at,
                normal: point.normal,
                area: point.area,
                gap: point.gap,
                row: shares.iter().map(|s| (s.node, s.weight)).collect(),
                slopes: shares.iter().map(|s| (s.node, s.slope)).collect(),
            });
        }
        solid
            .idle()
            .map_or(Ok(solid), |particle| Err(NoParticles::Idle { particle }))
    }

    /// The particles, in the order of their unknowns.
    pub fn particles(&self) -> &[Particle] {
        self.field.particles()
    }

    fn shares_of(&self, at: &Vector3<f64>) -> Result<Vec<Share>, NoParticles> {
        let shares = self.field.shares(at);
        shares.ok_or_else(|| NoParticles::Uncovered { at: (*at).into() })
    }

    /// The element of a cube; its weight and its points are taken up.
    fn part(&mut self, points: &[VolumePoint], mesh: &Mesh, weight: &Vector3<f64>) -> Result<Part, NoParticles> {
        let shares: Result<Vec<_>, _> = points.iter().map(|p| self.shares_of(&p.at)).collect();
        let shares = shares?;
        // In the order of their numbers, so that sums are in one order.
        let vectors: BTreeSet<u32> = shares.iter().flatten().map(|s| s.node).collect();
        let vectors: Vec<u32> = vectors.into_iter().collect();
        let each = points.iter().zip(&shares).map(|(point, shares)| {
            // Not all points of a cube are moved by the same particles.
            let mut slopes = vec![Vector3::zeros(); vectors.len()];
            for share in shares {
                let place = vectors.partition_point(|v| *v < share.node);
                slopes[place] = share.slope;
            }
            Point {
                weight: point.volume,
                at: point.at,
                slopes,
            }
        });
        let each: Vec<Point> = each.collect();
        for (point, shares) in points.iter().zip(&shares) {
            for share in shares {
                let n = 3 * share.node as usize;
                (0..3).for_each(|k| self.weights[n + k] += weight[k] * point.volume * share.weight);
            }
            let row = shares.iter().map(|s| (s.node, s.weight)).collect();
            self.inner.push(Inner { at: point.at, row });
        }
        let table = Table::new(vectors.len(), &each, mesh.dilatation())?;
        Ok(Part { vectors, table })
    }

    /// A particle whose unknowns nothing holds.
    fn idle(&self) -> Option<usize> {
        let mut moves = vec![false; self.particles().len()];
        for part in &self.parts {
            part.vectors.iter().for_each(|v| moves[*v as usize / VECTORS] = true);
        }
        moves.iter().position(|moves| !moves)
    }

    fn weight_energy(&self, a: &[f64]) -> f64 {
        -self.weights.iter().zip(a).map(|(w, a)| w * a).sum::<f64>()
    }
}

/// The largest side of what holds all places.
fn extent(places: impl Iterator<Item = Vector3<f64>>) -> f64 {
    let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (low, high) = places.fold(none, |(low, high), x| (low.inf(&x), high.sup(&x)));
    (high - low).max()
}

impl Solid for Particles {
    fn parameters(&self) -> usize {
        UNKNOWNS * self.particles().len()
    }

    fn translate(&self, a: &mut [f64], by: Vector3<f64>) {
        // The frames stay as they are.
        for u in a.chunks_exact_mut(UNKNOWNS) {
            (0..3).for_each(|k| u[k] += by[k]);
        }
    }

    fn rotate(&self, a: &mut [f64], by: &Rotation3<f64>, centre: Vector3<f64>) {
        // `R - I` first: a small turn keeps its digits where places are large.
        let turn = by.matrix() - Matrix3::identity();
        for (particle, own) in self.particles().iter().zip(a.chunks_exact_mut(UNKNOWNS)) {
            let ends = (0..3).map(|k| Vector3::ith(k, particle.radius));
            let arms = std::iter::once(particle.at - centre).chain(ends);
            for (u, arm) in own.chunks_exact_mut(3).zip(arms) {
                let more = turn * (arm + Vector3::new(u[0], u[1], u[2]));
                (0..3).for_each(|k| u[k] += more[k]);
            }
        }
    }

    fn energy(&self, a: &[f64]) -> Option<f64> {
        let (mut energy, mut u) = (self.weight_energy(a), Vec::new());
        for part in &self.parts {
            energy += part.table.energy(&self.material, taken(&part.vectors, a, &mut u))?;
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        gradient.iter_mut().zip(&self.weights).for_each(|(g, w)| *g -= w);
        let (mut energy, mut u, mut forces) = (self.weight_energy(a), Vec::new(), Vec::new());
        for part in &self.parts {
            let u = taken(&part.vectors, a, &mut u);
            forces.clear();
            forces.resize(u.len(), 0.0);
            energy += part.table.gradient(&self.material, u, &mut forces)?;
            for (vector, force) in part.vectors.iter().zip(forces.chunks_exact(3)) {
                (0..3).for_each(|k| gradient[3 * *vector as usize + k] += force[k]);
            }
        }
        Some(energy).filter(|e| e.is_finite())
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        // A cube's particles are all coupled by it: one dense block of some fifty vectors.
        let (mut u, mut packed) = (Vec::new(), Vec::new());
        for part in &self.parts {
            let u = taken(&part.vectors, a, &mut u);
            part.table.stiffness(&self.material, u, convex, &mut packed)?;
            let unknown = |p: usize| offset + 3 * part.vectors[p / 3] as usize + p % 3;
            sink.add_block((0..u.len()).map(unknown), &packed);
        }
        Some(())
    }

    fn weight(&self, forces: &mut [f64]) {
        forces.iter_mut().zip(&self.weights).for_each(|(f, w)| *f += w);
    }

    /// At the points of the mesh: nothing is proved between them, as shares are no polynomials that could be bounded.
    fn least_determinant(&self, a: &[f64]) -> f64 {
        let mut u = Vec::new();
        let each = self.parts.iter();
        let each = each.map(|part| part.table.least_determinant(taken(&part.vectors, a, &mut u)));
        // What is no number stays.
        each.fold(f64::INFINITY, |a, b| if a.is_nan() || b >= a { a } else { b })
    }

    fn stiffness_scale(&self) -> f64 {
        // Against shear, as of a mesh, whose cubes' sides particles' radii stand for.
        let radius = self.particles().iter().map(|p| p.radius).fold(0.0, f64::max);
        2.0 * self.material.lame.mu * radius
    }

    fn shear_scale(&self) -> f64 {
        self.material.lame.mu
    }

    fn extent(&self) -> f64 {
        self.extent
    }

    fn places(&self) -> Vec<[f64; 3]> {
        self.particles().iter().flat_map(|p| [p.at.into(); UNKNOWNS]).collect()
    }

    fn points(&self) -> usize {
        self.surface.len()
    }

    fn reference(&self, point: usize) -> (Vector3<f64>, Vector3<f64>, f64) {
        let point = &self.surface[point];
        (point.at, point.normal, point.area)
    }

    fn gap(&self, point: usize) -> f64 {
        self.surface[point].gap
    }

    fn inner(&self) -> Vec<Inner> {
        self.inner.clone()
    }

    fn stretch(&self, a: &[f64], point: usize) -> f64 {
        let point = &self.surface[point];
        stretched(&point.normal, point.slopes.iter().copied(), a)
    }

    fn point(&self, a: &[f64], point: usize) -> Vector3<f64> {
        let mut at = self.surface[point].at;
        for (vector, weight) in &self.surface[point].row {
            (0..3).for_each(|k| at[k] += weight * a[3 * *vector as usize + k]);
        }
        at
    }

    fn combination(&self, point: usize) -> Option<&[(u32, f64)]> {
        Some(&self.surface[point].row)
    }

    fn rows(&self, _a: &[f64], point: usize, visit: &mut dyn FnMut(usize, Vector3<f64>)) {
        for (vector, weight) in &self.surface[point].row {
            (0..3).for_each(|k| visit(3 * *vector as usize + k, Vector3::ith(k, *weight)));
        }
    }

    fn shares(&self, at: &Vector3<f64>) -> Option<Vec<Share>> {
        self.field.shares(at)
    }
}

fn taken<'a>(vectors: &[u32], a: &[f64], u: &'a mut Vec<f64>) -> &'a [f64] {
    super::sums::taken(vectors, a, u);
    u
}
