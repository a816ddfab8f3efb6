//! The mixed form for nearly incompressible materials: discontinuous linear pressures, eliminated in each element.
//!
//! Of the energy `w_s + (lambda / 2) theta^2` the measure of volume `theta` is replaced by its mean-square projection on
//! the linear functions of the element's reference position, `Pi theta`. This is the two-field form
//! `p theta - p^2 / (2 lambda)` made stationary in the three pressures of the element, `p = lambda Pi theta`; no unknown
//! is added and the energy keeps its minimum. Plain elements lock as `nu` nears 1/2, and their Newton steps fail.

use nalgebra::{Matrix3, SMatrix, Vector2, Vector3};

use super::blocks::{Blocks, DOFS, Forces, Stiffness, add_forces, clamped};
use super::{GaussPoint, NODES};
use crate::law::{Material, Volume};

/// The linear functions of an element at its Gauss points, and the inverse of their mass matrix.
#[derive(Debug, Clone)]
pub(super) struct Pressure {
    basis: Vec<Vector3<f64>>,
    inverse_mass: Matrix3<f64>,
    centre: Vector2<f64>,
    size: f64,
}

impl Pressure {
    /// Functions `1, x, y` of the position about the centre, in units of the element's size.
    pub(super) fn new(nodes: &[Vector2<f64>; NODES], points: &[GaussPoint]) -> Option<Self> {
        let at = |p: &GaussPoint| -> Vector2<f64> { nodes.iter().zip(p.values).map(|(n, w)| n * w).sum() };
        let area: f64 = points.iter().map(|p| p.weight).sum();
        let centre: Vector2<f64> = points.iter().map(|p| at(p) * p.weight).sum::<Vector2<f64>>() / area;
        let second: f64 = points.iter().map(|p| (at(p) - centre).norm_squared() * p.weight).sum();
        // In units of the radius of gyration the mass matrix has the same condition in large and small elements.
        let size = (second / area).sqrt();
        let basis = points.iter().map(|p| {
            let x = (at(p) - centre) / size;
            Vector3::new(1.0, x.x, x.y)
        });
        let basis: Vec<Vector3<f64>> = basis.collect();
        let mass: Matrix3<f64> = basis
            .iter()
            .zip(points)
            .map(|(b, p)| b * b.transpose() * p.weight)
            .sum();
        let inverse_mass = mass.try_inverse()?;
        Some(Self {
            basis,
            inverse_mass,
            centre,
            size,
        })
    }

    /// Coefficients of `Pi theta`.
    fn project(&self, points: &[GaussPoint], theta: impl Fn(usize) -> f64) -> Vector3<f64> {
        let moments = self.basis.iter().zip(points).enumerate();
        self.inverse_mass
            * moments
                .map(|(k, (b, p))| b * (p.weight * theta(k)))
                .sum::<Vector3<f64>>()
    }

    /// `Pi theta` at a reference position.
    pub(super) fn theta(
        &self,
        points: &[GaussPoint],
        material: &Material,
        u: &[Vector2<f64>; NODES],
        reference: Vector2<f64>,
    ) -> Option<f64> {
        let volumes = Self::volumes(points, material, u)?;
        let mean = self.project(points, |k| volumes[k].theta);
        let x = (reference - self.centre) / self.size;
        Some(mean.dot(&Vector3::new(1.0, x.x, x.y)))
    }

    pub(super) fn energy(&self, points: &[GaussPoint], material: &Material, u: &[Vector2<f64>; NODES]) -> Option<f64> {
        let mut theta = vec![0.0; points.len()];
        let mut energy = 0.0;
        for (theta, point) in theta.iter_mut().zip(points) {
            let g = point.gradient(u);
            *theta = material.volume(&g)?.theta;
            energy += point.weight * material.shear_density(&g)?;
        }
        let mean = self.project(points, |k| theta[k]);
        Some(energy + self.volume_energy(material, points, &mean)).filter(|e| e.is_finite())
    }

    /// `(lambda / 2) int (Pi theta)^2`.
    fn volume_energy(&self, material: &Material, points: &[GaussPoint], mean: &Vector3<f64>) -> f64 {
        let square = |(b, p): (&Vector3<f64>, &GaussPoint)| p.weight * b.dot(mean).powi(2);
        0.5 * material.lame.lambda * self.basis.iter().zip(points).map(square).sum::<f64>()
    }

    fn volumes(points: &[GaussPoint], material: &Material, u: &[Vector2<f64>; NODES]) -> Option<Vec<Volume>> {
        points.iter().map(|p| material.volume(&p.gradient(u))).collect()
    }

    pub(super) fn gradient(
        &self,
        points: &[GaussPoint],
        material: &Material,
        u: &[Vector2<f64>; NODES],
        forces: &mut Forces,
    ) -> Option<f64> {
        let volumes = Self::volumes(points, material, u)?;
        let mean = self.project(points, |k| volumes[k].theta);
        let mut energy = self.volume_energy(material, points, &mean);
        for ((point, basis), volume) in points.iter().zip(&self.basis).zip(&volumes) {
            let shear = material.shear(&point.gradient(u))?;
            let pressure = material.lame.lambda * basis.dot(&mean);
            add_forces(point, &(shear.stress + volume.gradient * pressure), forces);
            energy += point.weight * shear.density;
        }
        Some(energy).filter(|e| e.is_finite())
    }

    pub(super) fn stiffness(
        &self,
        points: &[GaussPoint],
        material: &Material,
        u: &[Vector2<f64>; NODES],
        convex: bool,
    ) -> Option<Stiffness> {
        let lambda = material.lame.lambda;
        let volumes = Self::volumes(points, material, u)?;
        let mean = self.project(points, |k| volumes[k].theta);
        let mut blocks = Blocks::default();
        // Columns: how much the three moments of theta change with each degree of freedom.
        let mut moments = SMatrix::<f64, DOFS, 3>::zeros();
        for ((point, basis), volume) in points.iter().zip(&self.basis).zip(&volumes) {
            let g = point.gradient(u);
            // The projected pressure in the place of `lambda theta`; what the projection couples follows after the
            // loop.
            let tangent = material.shear(&g)?.tangent + volume.hessian * (lambda * basis.dot(&mean));
            blocks.add(point, &clamped(material, tangent, &g, convex));
            let mut change = Forces::zeros();
            add_forces(point, &volume.gradient, &mut change);
            moments += change * basis.transpose();
        }
        // `lambda B M^-1 B^T`, the three pressures eliminated: their Schur complement.
        Some(blocks.stiffness() + moments * (self.inverse_mass * lambda) * moments.transpose())
    }
}
