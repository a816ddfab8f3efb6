//! What particles move: a place by those whose kernels reach it.
//!
//! A particle at `X_i` with radius `R_i` has the kernel `w_i(X) = (1 - |X - X_i|^2 / R_i^2)^3` within its radius, twice differentiable, and
//! the share `phi_i = w_i / sum_j w_j` (Shepard 1968). Its displacement is an affine function, so that a place moves by
//! `sum_i phi_i (u_i + G_i (X - X_i))`: affine motions of all particles together are reproduced exactly.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::{NoParticles, Particle};
use crate::space::cells::Share;

/// Vectors of unknowns to a particle: its displacement, and three columns of its gradient.
pub(super) const VECTORS: usize = 4;
/// A place where the kernels sum to less is not covered: it hangs on the rim of a single one, where shares change within no distance.
const LEAST: f64 = 0.02;

/// Particles, found by where they are.
#[derive(Debug, Clone)]
pub(super) struct Field {
    particles: Vec<Particle>,
    /// Side of the bins, the largest radius.
    bin: f64,
    bins: BTreeMap<[i64; 3], Vec<u32>>,
}

/// A kernel at a place: its value and two derivatives.
struct Kernel {
    particle: u32,
    value: f64,
    slope: Vector3<f64>,
    curvature: Matrix3<f64>,
}

impl Kernel {
    fn of(number: u32, particle: &Particle, at: &Vector3<f64>) -> Option<Self> {
        // A polynomial of the squared distance: smooth in the middle, where the distance has no slope.
        let (d, square) = (at - particle.at, particle.radius * particle.radius);
        let t = 1.0 - d.norm_squared() / square;
        (t > 0.0).then(|| Self {
            particle: number,
            value: t * t * t,
            slope: d * (-6.0 * t * t / square),
            curvature: d * d.transpose() * (24.0 * t / (square * square))
                - Matrix3::from_diagonal_element(6.0 * t * t / square),
        })
    }
}

impl Field {
    pub(super) fn new(particles: &[Particle]) -> Result<Self, NoParticles> {
        let bad = |p: &Particle| !(p.at.iter().all(|x| x.is_finite()) && p.radius.is_finite() && p.radius > 0.0);
        if let Some(particle) = particles.iter().position(bad) {
            return Err(NoParticles::Particle { particle });
        }
        let bin = particles.iter().map(|p| p.radius).fold(0.0, f64::max);
        let mut bins: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
        for (k, particle) in particles.iter().enumerate() {
            bins.entry(of_bin(&particle.at, bin)).or_default().push(k as u32);
        }
        Ok(Self {
            particles: particles.to_vec(),
            bin,
            bins,
        })
    }

    pub(super) fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// Vectors of unknowns with their parts in the displacement of a place, in the order of the particles. `None` where it is not covered.
    pub(super) fn shares(&self, at: &Vector3<f64>) -> Option<Vec<Share>> {
        let kernels = self.kernels(at);
        let sum: f64 = kernels.iter().map(|k| k.value).sum();
        if sum.is_nan() || sum < LEAST {
            return None;
        }
        let slope: Vector3<f64> = kernels.iter().map(|k| k.slope).sum();
        let curvature: Matrix3<f64> = kernels.iter().map(|k| k.curvature).sum();
        let mut shares = Vec::with_capacity(VECTORS * kernels.len());
        for kernel in kernels {
            // why the product's rule backwards: phi S = w, so phi' S + phi S' = w', and once more.
            let weight = kernel.value / sum;
            let first = (kernel.slope - slope * weight) / sum;
            let mixed = first * slope.transpose();
            let second = (kernel.curvature - mixed - mixed.transpose() - curvature * weight) / sum;
            self.affine(kernel.particle, at, (weight, first, second), &mut shares);
        }
        Some(shares)
    }

    /// The parts of a particle's four vectors. Those of its gradient are told by its radius, so that all are lengths.
    fn affine(
        &self,
        number: u32,
        at: &Vector3<f64>,
        (weight, slope, curvature): (f64, Vector3<f64>, Matrix3<f64>),
        shares: &mut Vec<Share>,
    ) {
        let node = VECTORS as u32 * number;
        shares.push(Share {
            node,
            weight,
            slope,
            curvature,
        });
        let particle = &self.particles[number as usize];
        // why lengths: all unknowns have the unit of length, so that one tolerance of forces serves them.
        let from = (at - particle.at) / particle.radius;
        for k in 0..3 {
            let axis = Vector3::ith(k, 1.0 / particle.radius);
            // The factor is linear: its slope meets that of the share twice, and it has no second derivative.
            let mixed = slope * axis.transpose();
            shares.push(Share {
                node: node + 1 + k as u32,
                weight: weight * from[k],
                slope: slope * from[k] + axis * weight,
                curvature: curvature * from[k] + mixed + mixed.transpose(),
            });
        }
    }

    fn kernels(&self, at: &Vector3<f64>) -> Vec<Kernel> {
        // A bin is as large as the largest radius: what reaches a place is in its own and the 26 about it.
        let middle = of_bin(at, self.bin);
        let around = (-1..=1).flat_map(|z| (-1..=1).flat_map(move |y| (-1..=1).map(move |x| [x, y, z])));
        let near = around.filter_map(|by: [i64; 3]| {
            let bin = std::array::from_fn(|k| middle[k].saturating_add(by[k]));
            self.bins.get(&bin)
        });
        let mut numbers: Vec<u32> = near.flatten().copied().collect();
        // Sums are in one order, wherever bins begin.
        numbers.sort_unstable();
        let each = numbers.into_iter();
        each.filter_map(|k| Kernel::of(k, &self.particles[k as usize], at))
            .collect()
    }
}

fn of_bin(at: &Vector3<f64>, bin: f64) -> [i64; 3] {
    [at.x, at.y, at.z].map(|x| (x / bin).floor() as i64)
}
