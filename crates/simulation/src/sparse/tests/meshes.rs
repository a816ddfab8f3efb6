//! Matrices that the tests share.

use nalgebra::{DMatrix, Matrix3};

use super::super::Triplets;

/// Numbers that look random, in -1/2 to 1/2, the same every time.
pub(super) struct Numbers(pub(super) u64);

impl Numbers {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        ((self.next() + 0.5) * n as f64) as usize % n
    }
}

/// A random graph's matrix: so many edges a vertex, in one or more parts without an edge between them.
pub(super) fn random(size: usize, edges: usize, parts: usize, diagonal: f64, seed: u64) -> Triplets {
    let mut numbers = Numbers(seed);
    let mut triplets = Triplets::new(size);
    for i in 0..size {
        triplets.add(i, i, diagonal + numbers.next());
        for _ in 0..edges {
            let j = numbers.below(size);
            if j != i && i % parts == j % parts {
                triplets.add(i, j, numbers.next());
            }
        }
    }
    triplets
}

pub(super) fn dense(triplets: &Triplets) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(triplets.size(), triplets.size());
    for (&(i, j), value) in triplets.places.iter().zip(&triplets.values) {
        dense[(i as usize, j as usize)] += value;
        if i != j {
            dense[(j as usize, i as usize)] += value;
        }
    }
    dense
}

/// A cube of so many cells of eight nodes along each edge, linear elastic, its lowest layer held; Young's modulus 1 or `soft`, cell by
/// cell. With the place of each unknown.
pub(super) fn elastic(cells: usize, ratio: f64, soft: f64) -> (Triplets, Vec<[f64; 3]>) {
    let side = cells + 1;
    let mut triplets = Triplets::new(3 * side * side * cells);
    let mut places = vec![[0.0; 3]; triplets.size()];
    let stiffness = cell(ratio);
    for c in 0..cells.pow(3) {
        let at = [c % cells, c / cells % cells, c / cells / cells];
        let modulus = if at[2].is_multiple_of(2) { 1.0 } else { soft };
        let unknown = |k: usize| {
            let [x, y, z]: [usize; 3] = std::array::from_fn(|d| at[d] + ((k / 3) >> d & 1));
            (z > 0).then(|| (3 * (x + side * (y + side * (z - 1))) + k % 3, [x, y, z]))
        };
        for k in 0..24 {
            let Some((i, place)) = unknown(k) else { continue };
            places[i] = place.map(|x| x as f64);
            for l in 0..=k {
                if let Some((j, _)) = unknown(l) {
                    triplets.add(i, j, modulus * stiffness[(k, l)]);
                }
            }
        }
    }
    (triplets, places)
}

/// The stiffness of a unit cube of Young's modulus 1: two points along each edge integrate it.
fn cell(ratio: f64) -> DMatrix<f64> {
    let (lambda, mu) = (ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio)), 0.5 / (1.0 + ratio));
    let mut stiffness = DMatrix::zeros(24, 24);
    for p in 0..8 {
        let x: [f64; 3] = std::array::from_fn(|d| 0.5 + (f64::from((p >> d) & 1) - 0.5) / 3.0_f64.sqrt());
        let slope = |node: usize, d: usize| {
            let part = |e: usize| {
                let far = (node >> e) & 1 == 1;
                match (e == d, far) {
                    (true, far) => {
                        if far {
                            1.0
                        } else {
                            -1.0
                        }
                    }
                    (_, true) => x[e],
                    (_, false) => 1.0 - x[e],
                }
            };
            (0..3).map(part).product::<f64>()
        };
        for a in 0..8 {
            for b in 0..8 {
                let g = Matrix3::from_fn(|i, j| slope(a, i) * slope(b, j));
                for i in 0..3 {
                    for j in 0..3 {
                        let same = if i == j { g.trace() } else { 0.0 };
                        stiffness[(3 * a + i, 3 * b + j)] += (lambda * g[(i, j)] + mu * g[(j, i)] + mu * same) / 8.0;
                    }
                }
            }
        }
    }
    stiffness
}
