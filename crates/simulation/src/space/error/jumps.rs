//! Jumps of the traction over faces between cubes: where a mesh is too coarse.
//!
//! The exact stress is continuous; an element's is not. After Kelly, Gago, Zienkiewicz and Babuska (1983) each face counts with
//! `h / 24` times the integral of the squared jump of the traction, here by the shear modulus: an energy. The numbers order
//! cubes; no error is stated by them alone.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4};

use crate::space::cells::{Cell, Mesh, VolumePoint};
use crate::space::element::Table;
use crate::space::law::Material;

/// Kelly's factor.
const FACTOR: f64 = 1.0 / 24.0;
/// Places of the rule of two points a side, from the middle of a face in sides.
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// What each cube has in the jumps at its faces.
#[derive(Debug, Clone, PartialEq)]
pub struct Jumps {
    /// Cubes in the mesh's order, each with half of what its faces have, stress times volume.
    pub cubes: Vec<(Cell, f64)>,
}

impl Jumps {
    /// Of a state of a body of this mesh and material, unknowns counted from the body's own first one. `None` where the law has no
    /// stress at a point. Faces that no cube lies beyond do not count.
    pub fn new(mesh: &Mesh, material: &Material, a: &[f64]) -> Option<Self> {
        let parts = mesh.parts();
        let mut fields = Vec::with_capacity(parts.len());
        // A cube that is nearly empty shares the dilatations of its neighbour: no face between the two counts.
        let mut owner = vec![0; mesh.cubes().len()];
        let mut volume = vec![0.0; mesh.cubes().len()];
        for (number, ((cubes, points), element)) in parts.iter().zip(&mesh.elements).enumerate() {
            let u: Vec<f64> = element
                .nodes
                .iter()
                .flat_map(|n| &a[3 * *n as usize..3 * *n as usize + 3])
                .copied()
                .collect();
            fields.push(Linear::fitted(mesh.table(element), material, &u, points)?);
            cubes.iter().for_each(|c| owner[*c] = number);
        }
        for point in mesh.points() {
            volume[point.cube()] += point.volume;
        }
        let number: BTreeMap<Cell, usize> = mesh.cubes().iter().enumerate().map(|(k, c)| (*c, k)).collect();
        let mut sums = vec![0.0; mesh.cubes().len()];
        let fill = |k: usize| (volume[k] / mesh.grid().length(mesh.cubes()[k].span).powi(3)).min(1.0);
        for (k, cell) in mesh.cubes().iter().enumerate() {
            for other in mesh.grid().across(cell) {
                let Some(&j) = number.get(&other).filter(|j| **j > k && owner[**j] != owner[k]) else {
                    continue;
                };
                let face = Face::between(mesh, cell, &other);
                // How much of a face is inside is not known: at most so much of it as of either cube.
                let share = fill(k).min(fill(j));
                let energy = face.jump(&fields[owner[k]], &fields[owner[j]]) * share / material.lame.mu;
                // Half to either side, as in Kelly's estimate.
                sums[k] += 0.5 * energy;
                sums[j] += 0.5 * energy;
            }
        }
        Some(Self {
            cubes: mesh.cubes().iter().copied().zip(sums).collect(),
        })
    }

    /// The sum over all cubes.
    pub fn sum(&self) -> f64 {
        self.cubes.iter().map(|c| c.1).sum()
    }

    /// The fewest cubes that have this part of the sum, from 0 to 1: those to be halved ([`super::halved`]).
    pub fn worst(&self, part: f64) -> BTreeSet<Cell> {
        // By energy, and of equal ones by place: the same choice in every run.
        let mut order: Vec<&(Cell, f64)> = self.cubes.iter().collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let (all, mut sum, mut chosen) = (self.sum(), 0.0, BTreeSet::new());
        for (cell, energy) in order {
            if sum >= part * all {
                break;
            }
            sum += energy;
            chosen.insert(*cell);
        }
        chosen
    }
}

/// An element's stress as the linear function nearest to it at its points.
struct Linear {
    centre: Vector3<f64>,
    scale: f64,
    /// Entries of the first Piola-Kirchhoff stress, column by column: value at the centre and slopes by the scale.
    entries: SMatrix<f64, 4, 9>,
}

impl Linear {
    fn fitted(table: &Table, material: &Material, u: &[f64], points: &[VolumePoint]) -> Option<Self> {
        let volume: f64 = points.iter().map(|p| p.volume).sum();
        let centre = points.iter().map(|p| p.at * (p.volume / volume)).sum::<Vector3<f64>>();
        let square = points
            .iter()
            .map(|p| (p.at - centre).norm_squared() * p.volume)
            .sum::<f64>();
        let scale = (square / volume).sqrt().max(f64::MIN_POSITIVE);
        let (mut moments, mut sums) = (Matrix4::zeros(), SMatrix::<f64, 4, 9>::zeros());
        for (k, point) in points.iter().enumerate() {
            let state = table.state(material, u, k)?;
            let deformation = Matrix3::identity() + state.gradient;
            // Of small strains the law's stress is meant as it is, whatever the determinant.
            let piola = match deformation.try_inverse() {
                Some(inverse) if state.determinant > 0.0 && material.law != crate::law::Law::Linear => {
                    state.cauchy * inverse.transpose() * state.determinant
                }
                _ => state.cauchy,
            };
            // By least squares with the points' volumes: the nearest linear field to what the points have.
            let basis = basis(&((point.at - centre) / scale));
            moments += basis * basis.transpose() * point.volume;
            sums += basis * SMatrix::<f64, 1, 9>::from_row_slice(piola.as_slice()) * point.volume;
        }
        // Points in a plane do not tell the slope across it: next to none is taken.
        moments += Matrix4::from_diagonal_element(1e-9 * volume);
        let entries = moments.cholesky()?.solve(&sums);
        Some(Self { centre, scale, entries })
    }

    fn at(&self, place: &Vector3<f64>) -> Matrix3<f64> {
        let row = basis(&((place - self.centre) / self.scale)).transpose() * self.entries;
        Matrix3::from_column_slice(row.as_slice())
    }
}

fn basis(by: &Vector3<f64>) -> Vector4<f64> {
    Vector4::new(1.0, by.x, by.y, by.z)
}

/// The face that two cubes share, a square.
struct Face {
    middle: Vector3<f64>,
    axis: usize,
    side: f64,
}

impl Face {
    fn between(mesh: &Mesh, one: &Cell, other: &Cell) -> Self {
        let [a, b] = [one, other].map(|c| mesh.grid().corners(c));
        // Across the face they touch in a plane, along it they overlap by the smaller one.
        let (low, high) = (a[0].sup(&b[0]), a[1].inf(&b[1]));
        Self {
            middle: (low + high) * 0.5,
            axis: (high - low).imin(),
            side: (high - low).max(),
        }
    }

    /// `h / 24` times the integral of the squared jump of the traction.
    fn jump(&self, one: &Linear, other: &Linear) -> f64 {
        let mut squares = 0.0;
        for k in 0..4 {
            let mut place = self.middle;
            place[(self.axis + 1) % 3] += self.side * if k % 2 == 0 { GAUSS } else { -GAUSS };
            place[(self.axis + 2) % 3] += self.side * if k < 2 { GAUSS } else { -GAUSS };
            let jump = one.at(&place) - other.at(&place);
            squares += 0.25 * jump.column(self.axis).norm_squared();
        }
        FACTOR * self.side.powi(3) * squares
    }
}
