//! Springs at points that the same nodes move: one constant stiffness for all of them.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::space::solid::Solid;
use crate::sparse::Triplets;

/// A point that a spring holds: its number, where to, and stiffness times area.
pub(super) type Held = (usize, Vector3<f64>, f64);

/// Points of a surface that the same nodes move, each position a weighted sum of the nodes': those of one cube.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    nodes: Vec<u32>,
    /// From each reference place to where its spring pulls, axis by axis: all points of x, then of y, then of z.
    ways: Vec<f64>,
    /// Stiffness times area of each point.
    stiff: Vec<f64>,
    /// Node by node the weight of each point.
    weights: Vec<f64>,
    /// Pairs of nodes, the later one first, with their part of the stiffness, the same for each axis.
    pairs: Vec<(u32, u32, f64)>,
}

/// Memory for displacements of points, and for forces.
#[derive(Debug, Default)]
pub(super) struct Work(Vec<f64>);

/// Points by the nodes that move them, in the order of these; and those that no nodes move linearly.
pub(super) fn patches(solid: &dyn Solid, held: Vec<Held>) -> (Vec<Patch>, Vec<Held>) {
    let mut groups: BTreeMap<Vec<u32>, Vec<Held>> = BTreeMap::new();
    let mut others = Vec::new();
    for point in held {
        match solid.combination(point.0) {
            Some(row) => groups.entry(row.iter().map(|r| r.0).collect()).or_default().push(point),
            None => others.push(point),
        }
    }
    let each = groups.into_iter().map(|(nodes, held)| Patch::new(solid, nodes, &held));
    (each.collect(), others)
}

impl Patch {
    fn new(solid: &dyn Solid, nodes: Vec<u32>, held: &[Held]) -> Self {
        let count = held.len();
        let (mut weights, mut ways) = (vec![0.0; nodes.len() * count], vec![0.0; 3 * count]);
        for (k, (point, place, _)) in held.iter().enumerate() {
            let way = place - solid.reference(*point).0;
            (0..3).for_each(|axis| ways[axis * count + k] = way[axis]);
            for (n, (_, weight)) in solid.combination(*point).into_iter().flatten().enumerate() {
                weights[n * count + k] = *weight;
            }
        }
        let stiff: Vec<f64> = held.iter().map(|h| h.2).collect();
        let row = |n: usize| &weights[n * count..(n + 1) * count];
        let mut pairs = Vec::new();
        for n in 0..nodes.len() {
            for m in 0..=n {
                let each = row(n).iter().zip(row(m)).zip(&stiff);
                let sum: f64 = each.map(|((n, m), k)| k * (n * m)).sum();
                // On a face of a cube only the nodes of that face have a part.
                if sum != 0.0 {
                    pairs.push((nodes[n], nodes[m], sum));
                }
            }
        }
        Self {
            nodes,
            ways,
            stiff,
            weights,
            pairs,
        }
    }

    /// The energy; in `work` the forces on the points then, axis by axis.
    pub(super) fn energy(&self, a: &[f64], work: &mut Work) -> f64 {
        let count = self.stiff.len();
        let ways = &mut work.0;
        ways.clear();
        ways.extend_from_slice(&self.ways);
        for (node, weights) in self.nodes.iter().zip(self.weights.chunks_exact(count)) {
            let u = &a[3 * *node as usize..3 * *node as usize + 3];
            for (ways, u) in ways.chunks_exact_mut(count).zip(u) {
                ways.iter_mut()
                    .zip(weights)
                    .for_each(|(way, weight)| *way -= weight * u);
            }
        }
        let mut energy = 0.0;
        for ways in ways.chunks_exact_mut(count) {
            for (way, stiff) in ways.iter_mut().zip(&self.stiff) {
                let force = stiff * *way;
                energy += 0.5 * force * *way;
                *way = force;
            }
        }
        energy
    }

    /// The same, and its derivatives added to `gradient`.
    pub(super) fn gradient(&self, a: &[f64], gradient: &mut [f64], work: &mut Work) -> f64 {
        let count = self.stiff.len();
        let energy = self.energy(a, work);
        for (node, weights) in self.nodes.iter().zip(self.weights.chunks_exact(count)) {
            for (axis, forces) in work.0.chunks_exact(count).enumerate() {
                gradient[3 * *node as usize + axis] -= dot(forces, weights);
            }
        }
        energy
    }

    /// Adds the stiffness to `sink` from the unknown `offset` on.
    pub(super) fn add_stiffness(&self, sink: &mut Triplets, offset: usize) {
        for (n, m, stiff) in &self.pairs {
            let [n, m] = [n, m].map(|node| offset + 3 * *node as usize);
            (0..3).for_each(|axis| sink.add(n + axis, m + axis, *stiff));
        }
    }
}

/// Four sums side by side: one alone would wait for each addition.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((fours, rest), (others, other_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in fours.iter().zip(others) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let last: f64 = rest.iter().zip(other_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + last
}
