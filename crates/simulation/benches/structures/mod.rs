//! Structures that find samples near arcs.

mod bounds_tree;
mod grid;
mod quadtree;

use nalgebra::Vector2;
use simulation::constraint::near_boxes;

use crate::SAMPLES;

/// A box: its low and its high corner.
pub(crate) type Bounds = [Vector2<f64>; 2];

/// An arc with its samples and the box of its control triangle.
pub(crate) struct Arc {
    body: usize,
    samples: [Vector2<f64>; SAMPLES],
    bounds: Bounds,
}

impl Arc {
    pub(crate) fn new(body: usize, [a, b, c]: [Vector2<f64>; 3]) -> Self {
        let control = b * 2.0 - (a + c) * 0.5;
        let samples = std::array::from_fn(|k| {
            let u = 2.0 * k as f64 / SAMPLES as f64 - 1.0;
            a * (0.5 * u * (u - 1.0)) + b * (1.0 - u * u) + c * (0.5 * u * (u + 1.0))
        });
        Self {
            body,
            samples,
            bounds: [a.inf(&c).inf(&control), a.sup(&c).sup(&control)],
        }
    }
}

/// What was found: how many pairs, and a sum of their numbers that tells sets apart.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) pairs: usize,
    sum: u64,
}

impl Found {
    /// Counts sample `k` of an arc and another solid's arc, if they are near.
    fn look(&mut self, arcs: &[Arc], [own, k]: [usize; 2], other: usize, within: f64) {
        if arcs[own].body != arcs[other].body && distance(&arcs[other].bounds, &arcs[own].samples[k]) < within {
            self.pairs += 1;
            let number = ((own * SAMPLES + k) as u64) << 32 | other as u64;
            self.sum = self
                .sum
                .wrapping_add(number.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ number);
        }
    }

    /// All samples of two arcs against one another.
    fn look_at_both(&mut self, arcs: &[Arc], one: usize, two: usize, within: f64) {
        for k in 0..SAMPLES {
            self.look(arcs, [one, k], two, within);
            self.look(arcs, [two, k], one, within);
        }
    }
}

fn distance([low, high]: &Bounds, point: &Vector2<f64>) -> f64 {
    (low - point).sup(&(point - high)).sup(&Vector2::zeros()).norm()
}

fn near(a: &Bounds, b: &Bounds, within: f64) -> bool {
    (a[0] - b[1]).sup(&(b[0] - a[1])).max() <= within
}

/// A way to find them.
type Way = fn(&[Arc], f64) -> Found;

/// The oracle is the first that is run.
pub(crate) const WAYS: [(&str, Way); 5] = [
    ("all with all", all),
    ("quadtree of samples (thesis)", quadtree::find),
    ("tree of bounds", bounds_tree::find),
    ("grid", grid::find),
    ("sorted along an axis (used)", sorted),
];

fn all(arcs: &[Arc], within: f64) -> Found {
    let mut found = Found::default();
    for one in 0..arcs.len() {
        for two in one + 1..arcs.len() {
            found.look_at_both(arcs, one, two, within);
        }
    }
    found
}

fn sorted(arcs: &[Arc], within: f64) -> Found {
    let boxes: Vec<Bounds> = arcs.iter().map(|arc| arc.bounds).collect();
    let mut found = Found::default();
    for [one, two] in near_boxes(&boxes, within) {
        found.look_at_both(arcs, one as usize, two as usize, within);
    }
    found
}
