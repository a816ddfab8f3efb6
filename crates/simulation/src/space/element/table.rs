//! What an element is but for its displacements and its material; its energy and forces.

use nalgebra::{Matrix3, Vector3};

use super::modes::{self, MODES};
use super::{BadTable, Dilatation, Point};
use crate::space::law::{Material, Tensor, excess, vector};

/// Points whose displacement gradients are kept between the two passes of the forces; those of others are formed twice.
const KEPT: usize = 64;

/// Quadrature points and slopes of an element: one for all elements of a shape. Displacements `u` are `3 n` numbers, node
/// by node, in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    nodes: usize,
    pub(in crate::space) weights: Vec<f64>,
    /// Point by point, node by node.
    pub(in crate::space) slopes: Vec<[f64; 3]>,
    /// Of each point the values of the functions that are projected on; 0 beyond their count.
    modes: Vec<[f64; MODES]>,
    pub(in crate::space) mode_count: usize,
    volume: f64,
    /// `sum_p w_p Q_n . Q_m` of nodes `n >= m`, row by row.
    pub(in crate::space) laplacian: Vec<f64>,
}

impl Table {
    /// The most nodes of an element: bounds the memory of its stiffness.
    pub const MOST_NODES: usize = 512;

    /// An element of these points. Its rule is taken as it is: rigid motions cost no energy where the slopes of each point
    /// sum to zero, and turn into nothing else where they reproduce linear fields.
    ///
    /// # Errors
    /// [`BadTable`].
    pub fn new(nodes: usize, points: &[Point], dilatation: Dilatation) -> Result<Self, BadTable> {
        if nodes == 0 || points.is_empty() || nodes > Self::MOST_NODES {
            return Err(BadTable::Size {
                nodes,
                points: points.len(),
                most: Self::MOST_NODES,
            });
        }
        for (point, p) in points.iter().enumerate() {
            check(nodes, point, p)?;
        }
        let volume: f64 = points.iter().map(|p| p.weight).sum();
        // Weights that are finite one by one may still overflow together.
        if !volume.is_finite() {
            return Err(BadTable::Volume { found: volume });
        }
        // Of all that does not change with the state, what is used most is kept.
        let (modes, mode_count) = modes::orthonormal(points, dilatation);
        let entries = points.iter().flat_map(|p| &p.slopes);
        Ok(Self {
            nodes,
            weights: points.iter().map(|p| p.weight).collect(),
            slopes: entries.map(|q| [q.x, q.y, q.z]).collect(),
            modes,
            mode_count,
            volume,
            laplacian: laplacian(nodes, points),
        })
    }

    /// How many nodes it has.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// How many quadrature points it has.
    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// Its volume in the reference configuration, mm^3.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// The elastic energy. `None` where the law has none at a point. `u` must have `3 n` entries.
    pub fn energy(&self, material: &Material, u: &[f64]) -> Option<f64> {
        let (mut energy, mut means) = (0.0, [0.0; MODES]);
        for (point, weight) in self.weights.iter().enumerate() {
            let g = self.displacement_gradient(u, point);
            // Without a projection the law is asked whole: nothing couples the points.
            let density = if self.mode_count == 0 {
                material.density(&g)?
            } else {
                let g = vector(&g);
                self.add_mean(point, material.theta(&g)?, &mut means);
                material.shear_density(&g)?
            };
            energy += weight * density;
        }
        finite(energy + self.volume_energy(material, &means))
    }

    /// The elastic energy, and its derivatives by the displacements added to `forces`. `None` as [`Self::energy`];
    /// `forces` is then not to be used.
    pub fn gradient(&self, material: &Material, u: &[f64], forces: &mut [f64]) -> Option<f64> {
        let mut energy = 0.0;
        if self.mode_count == 0 {
            for (point, weight) in self.weights.iter().enumerate() {
                let (density, stress) = material.stress(&self.displacement_gradient(u, point))?;
                energy += weight * density;
                self.add_forces(point, &(stress * *weight), forces);
            }
            return finite(energy);
        }
        // The pressure at a point needs theta at all points: a first pass finds it, a second one the stresses.
        let mut kept = [Tensor::zeros(); KEPT];
        let mut means = [0.0; MODES];
        for point in 0..self.points() {
            let g = vector(&self.displacement_gradient(u, point));
            self.add_mean(point, material.theta(&g)?, &mut means);
            // Cells of more points than are kept pay a second sum, and no memory.
            if let Some(place) = kept.get_mut(point) {
                *place = g;
            }
        }
        for (point, weight) in self.weights.iter().enumerate() {
            let g = match kept.get(point) {
                Some(g) => *g,
                None => vector(&self.displacement_gradient(u, point)),
            };
            // The derivative of the projection's square is the projected pressure times the derivative of theta itself.
            let (density, stress) = material.shear_stress(&g)?;
            let (_, slope) = material.volume_slope(&g)?;
            let pressure = material.lame.lambda * self.projected(point, &means);
            energy += weight * density;
            self.add_forces(point, &((stress + slope * pressure) * *weight), forces);
        }
        finite(energy + self.volume_energy(material, &means))
    }

    /// The least `det F` at its points: a sample, no bound.
    pub fn least_determinant(&self, u: &[f64]) -> f64 {
        let determinant = |point: usize| 1.0 + excess(&vector(&self.displacement_gradient(u, point)));
        (0..self.points()).map(determinant).fold(f64::INFINITY, |a, b| {
            // A NaN stays: `f64::min` would drop it.
            if a.is_nan() || b >= a { a } else { b }
        })
    }

    /// The displacement gradient at a point.
    #[inline]
    pub(in crate::space) fn displacement_gradient(&self, u: &[f64], point: usize) -> Matrix3<f64> {
        let mut columns = [[0.0; 3]; 3];
        for (q, u) in self.slopes_at(point).iter().zip(u.as_chunks::<3>().0) {
            for (column, q) in columns.iter_mut().zip(q) {
                for (entry, u) in column.iter_mut().zip(u) {
                    *entry += u * q;
                }
            }
        }
        let [x, y, z] = columns.map(Vector3::from);
        Matrix3::from_columns(&[x, y, z])
    }

    #[inline]
    pub(in crate::space) fn slopes_at(&self, point: usize) -> &[[f64; 3]] {
        &self.slopes[self.nodes * point..self.nodes * (point + 1)]
    }

    /// `forces_ni += P_iJ Q_nJ`.
    #[inline]
    pub(in crate::space) fn add_forces(&self, point: usize, p: &Tensor, forces: &mut [f64]) {
        for (q, f) in self.slopes_at(point).iter().zip(forces.as_chunks_mut::<3>().0) {
            for (i, f) in f.iter_mut().enumerate() {
                *f += p[i] * q[0] + p[i + 3] * q[1] + p[i + 6] * q[2];
            }
        }
    }

    /// The functions that are projected on, at a point.
    #[inline]
    pub(in crate::space) fn modes_at(&self, point: usize) -> &[f64; MODES] {
        &self.modes[point]
    }

    /// Adds what a point gives to the coefficients of the projected `theta`: means of `theta` times a function.
    #[inline]
    pub(in crate::space) fn add_mean(&self, point: usize, theta: f64, means: &mut [f64; MODES]) {
        // Fractions of the volume, so that the unit of length drops out to the last bit.
        let part = self.weights[point] / self.volume * theta;
        for (mean, mode) in means.iter_mut().zip(self.modes_at(point)) {
            *mean += part * mode;
        }
    }

    /// The projected `theta` at a point.
    #[inline]
    pub(in crate::space) fn projected(&self, point: usize, means: &[f64; MODES]) -> f64 {
        means.iter().zip(self.modes_at(point)).map(|(m, b)| m * b).sum()
    }

    /// `(lambda / 2) int (Pi theta)^2`: the functions are orthonormal in the mean.
    fn volume_energy(&self, material: &Material, means: &[f64; MODES]) -> f64 {
        0.5 * material.lame.lambda * self.volume * means.iter().map(|m| m * m).sum::<f64>()
    }
}

fn laplacian(nodes: usize, points: &[Point]) -> Vec<f64> {
    let mut sums = vec![0.0; nodes * (nodes + 1) / 2];
    for point in points {
        let mut rest = sums.as_mut_slice();
        for (n, q) in point.slopes.iter().enumerate() {
            let (own, next) = rest.split_at_mut(n + 1);
            // Only pairs of the lower triangle: the matrix is symmetric.
            let weighted = q * point.weight;
            for (sum, q) in own.iter_mut().zip(&point.slopes) {
                *sum += weighted.dot(q);
            }
            rest = next;
        }
    }
    sums
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn check(nodes: usize, point: usize, p: &Point) -> Result<(), BadTable> {
    let found = p.slopes.len();
    if found != nodes {
        return Err(BadTable::Slopes { point, found, nodes });
    }
    if !(p.weight.is_finite() && p.weight > 0.0) {
        return Err(BadTable::Weight { point, found: p.weight });
    }
    let finite = p.at.iter().chain(p.slopes.iter().flatten()).all(|x| x.is_finite());
    if finite {
        Ok(())
    } else {
        Err(BadTable::NotFinite { point })
    }
}
