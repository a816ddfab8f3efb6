//! The second derivative of an element's energy.

use super::Table;
use super::modes::MODES;
use crate::space::law::{Material, Tangent, Tensor, vector};

/// Entries of the block of two nodes: row by row.
const BLOCK: usize = 9;

impl Table {
    /// The second derivative of the energy by the displacements, its lower triangle row by row (`3n (3n + 1) / 2` numbers,
    /// as [`crate::sparse::Triplets::add_block`] takes them); where `convex`, of the nearest positive semidefinite
    /// tangents. `packed` is cleared first, and no memory is asked for where it has held a stiffness of this element before.
    /// `None` where the law has no energy; `packed` is then not to be used.
    pub fn stiffness(&self, material: &Material, u: &[f64], convex: bool, packed: &mut Vec<f64>) -> Option<()> {
        let (n, unknowns) = (self.nodes(), 3 * self.nodes());
        let length = unknowns * (unknowns + 1) / 2;
        let (blocks, changes) = (BLOCK * n * (n + 1) / 2, self.mode_count * unknowns);
        // Behind the result there is room for the blocks and for the derivatives of the means of theta.
        packed.clear();
        packed.resize(length + blocks + changes, 0.0);
        let (result, rest) = packed.split_at_mut(length);
        let (blocks, changes) = rest.split_at_mut(blocks);
        self.add_points(material, u, convex, blocks, changes)?;
        unpack(n, blocks, result);
        // The pressures eliminated: one square for each function, as these are orthonormal.
        for change in changes.chunks_exact(unknowns) {
            add_square(material.lame.lambda / self.volume(), change, result);
        }
        packed.truncate(length);
        Some(())
    }

    fn add_points(
        &self,
        material: &Material,
        u: &[f64],
        convex: bool,
        blocks: &mut [f64],
        changes: &mut [f64],
    ) -> Option<()> {
        self.tangents(material, u, convex, changes, |point, tangent| {
            add_blocks(self.slopes_at(point), tangent, blocks);
        })
    }

    /// Calls `each` with every point and its tangent times its weight, made convex where asked for; adds to `changes` the
    /// derivatives of the means of `theta` times the volume, function by function. `None` where the law has no energy.
    pub(in crate::space) fn tangents(
        &self,
        material: &Material,
        u: &[f64],
        convex: bool,
        changes: &mut [f64],
        mut each: impl FnMut(usize, &Tangent),
    ) -> Option<()> {
        // Only where something is projected, as theta of all points takes a pass of its own.
        let means = match self.mode_count {
            0 => [0.0; MODES],
            _ => self.means(material, u)?,
        };
        for (point, weight) in self.weights.iter().enumerate() {
            let gradient = self.displacement_gradient(u, point);
            let mut tangent = if self.mode_count == 0 {
                material.tangent(&gradient)?
            } else {
                let g = vector(&gradient);
                // The projected pressure in the place of `lambda theta`; what the projection couples follows after.
                let pressure = material.lame.lambda * self.projected(point, &means);
                self.add_changes(point, &(material.volume_slope(&g)?.1 * *weight), changes);
                material.tangent_at_pressure(&g, pressure)?
            };
            // Point by point: a sum of parts without negative directions has none.
            if convex {
                tangent = material.convex(&tangent, &gradient);
            }
            tangent *= *weight;
            // Nothing else of the tangent is looked at before it is a Newton step.
            if !tangent.sum().is_finite() {
                return None;
            }
            each(point, &tangent);
        }
        Some(())
    }

    /// Adds what a point gives to the derivatives of the means of `theta` by the displacements, times the volume.
    fn add_changes(&self, point: usize, slope: &Tensor, changes: &mut [f64]) {
        let unknowns = 3 * self.nodes();
        for (change, mode) in changes.chunks_exact_mut(unknowns).zip(self.modes_at(point)) {
            self.add_forces(point, &(slope * *mode), change);
        }
    }
}

/// `K_(ni)(mk) += Q_nJ A_(iJ)(kL) Q_mL` for nodes `n >= m`.
fn add_blocks(slopes: &[[f64; 3]], a: &Tangent, blocks: &mut [f64]) {
    let mut rest = blocks;
    for (n, qn) in slopes.iter().enumerate() {
        // One half of the product is formed once for a node: a pair pays for the other half only.
        let by_axis = contracted(a, qn);
        // Blocks of a node with itself and with those before it follow one another.
        let (own, others) = rest.split_at_mut(BLOCK * (n + 1));
        for (block, qm) in own.as_chunks_mut::<BLOCK>().0.iter_mut().zip(slopes) {
            // A block is nine numbers in a row: the innermost loop is as wide as the machine's registers or wider.
            for (k, entry) in block.iter_mut().enumerate() {
                *entry += by_axis[0][k] * qm[0] + by_axis[1][k] * qm[1] + by_axis[2][k] * qm[2];
            }
        }
        rest = others;
    }
}

/// For each axis `L` the block `sum_J Q_J A_(iJ)(kL)`, row by row in `(i, k)`.
fn contracted(a: &Tangent, q: &[f64; 3]) -> [[f64; BLOCK]; 3] {
    std::array::from_fn(|axis| {
        std::array::from_fn(|entry| {
            let (i, column) = (entry / 3, entry % 3 + 3 * axis);
            q[0] * a[(i, column)] + q[1] * a[(i + 3, column)] + q[2] * a[(i + 6, column)]
        })
    })
}

/// From blocks to the lower triangle row by row.
fn unpack(nodes: usize, blocks: &[f64], packed: &mut [f64]) {
    let (mut blocks, mut rows) = (blocks, packed);
    for n in 0..nodes {
        let (own, others) = blocks.split_at(BLOCK * (n + 1));
        for i in 0..3 {
            let (row, next) = rows.split_at_mut(3 * n + i + 1);
            // The last block of a row is cut by the diagonal, where its chunk is shorter.
            for (to, from) in row.chunks_mut(3).zip(own.chunks_exact(BLOCK)) {
                to.copy_from_slice(&from[3 * i..3 * i + to.len()]);
            }
            rows = next;
        }
        blocks = others;
    }
}

/// `packed += factor c c^T`.
fn add_square(factor: f64, c: &[f64], packed: &mut [f64]) {
    let mut rows = packed;
    for (row, value) in c.iter().enumerate() {
        let (own, next) = rows.split_at_mut(row + 1);
        let scaled = factor * value;
        own.iter_mut().zip(c).for_each(|(entry, c)| *entry += scaled * c);
        rows = next;
    }
}
