//! A quadtree of samples, asked by the boxes of arcs (the thesis, II 3.3.2).

use nalgebra::Vector2;

use super::{Arc, Bounds, Found};
use crate::SAMPLES;

/// Samples of a leaf at most, and how deep the tree may grow.
const LEAF: usize = 8;
const DEEPEST: usize = 24;

/// A square: its samples if it is a leaf, else where its four quarters are.
struct Node {
    centre: Vector2<f64>,
    half: f64,
    samples: std::ops::Range<usize>,
    quarters: Option<usize>,
}

struct Quadtree {
    nodes: Vec<Node>,
    /// Samples `(arc, number)` with their places, those of a leaf together.
    order: Vec<(Vector2<f64>, [u32; 2])>,
}

impl Quadtree {
    fn new(arcs: &[Arc]) -> Self {
        let infinity = Vector2::repeat(f64::INFINITY);
        let [low, high] = arcs.iter().fold([infinity, -infinity], |b, arc| {
            [b[0].inf(&arc.bounds[0]), b[1].sup(&arc.bounds[1])]
        });
        let samples = (0..arcs.len()).flat_map(|arc| (0..SAMPLES).map(move |k| [arc as u32, k as u32]));
        let order: Vec<_> = samples
            .map(|[a, k]| (arcs[a as usize].samples[k as usize], [a, k]))
            .collect();
        let root = Node {
            centre: (low + high) * 0.5,
            half: 0.5 * (high - low).max(),
            samples: 0..order.len(),
            quarters: None,
        };
        let mut tree = Self {
            nodes: vec![root],
            order,
        };
        tree.split(0, 0);
        tree
    }

    fn split(&mut self, node: usize, depth: usize) {
        let (centre, half, range) = {
            let n = &self.nodes[node];
            (n.centre, 0.5 * n.half, n.samples.clone())
        };
        if range.len() <= LEAF || depth >= DEEPEST {
            return;
        }
        let quarter = |p: &Vector2<f64>| usize::from(p.x >= centre.x) + 2 * usize::from(p.y >= centre.y);
        self.order[range.clone()].sort_unstable_by_key(|s| quarter(&s.0));
        let first = self.nodes.len();
        self.nodes[node].quarters = Some(first);
        let mut start = range.start;
        for q in 0..4 {
            let count = self.order[start..range.end]
                .iter()
                .take_while(|s| quarter(&s.0) == q)
                .count();
            let sign = |bit: usize| if q & bit == 0 { -half } else { half };
            self.nodes.push(Node {
                centre: centre + Vector2::new(sign(1), sign(2)),
                half,
                samples: start..start + count,
                quarters: None,
            });
            start += count;
        }
        (first..first + 4).for_each(|child| self.split(child, depth + 1));
    }

    /// Calls `visit` with the samples of every leaf that comes as near to a box as `within`.
    fn ask(&self, bounds: &Bounds, within: f64, visit: &mut impl FnMut([u32; 2])) {
        let (middle, half) = ((bounds[0] + bounds[1]) * 0.5, (bounds[1] - bounds[0]) * 0.5);
        let reach = half + Vector2::repeat(within * (1.0 + 1e-9));
        let mut stack = vec![0];
        while let Some(k) = stack.pop() {
            let node = &self.nodes[k];
            let apart = (node.centre - middle).abs() - reach;
            if apart.max() > node.half * (1.0 + 1e-9) {
                continue;
            }
            match node.quarters {
                Some(first) => stack.extend(first..first + 4),
                None => self.order[node.samples.clone()].iter().for_each(|s| visit(s.1)),
            }
        }
    }
}

pub(super) fn find(arcs: &[Arc], within: f64) -> Found {
    let tree = Quadtree::new(arcs);
    let mut found = Found::default();
    for (other, arc) in arcs.iter().enumerate() {
        tree.ask(&arc.bounds, within, &mut |[own, k]| {
            found.look(arcs, [own as usize, k as usize], other, within);
        });
    }
    found
}
