//! A tree of the boxes of arcs, halved at the median of the longer side, asked by samples' arcs.

use nalgebra::Vector2;

use super::{Arc, Bounds, Found, near};

/// Arcs of a leaf at most.
const LEAF: usize = 4;

struct Node {
    bounds: Bounds,
    arcs: std::ops::Range<usize>,
    /// The second half; the first one follows its parent.
    second: Option<usize>,
}

struct Tree {
    nodes: Vec<Node>,
    order: Vec<usize>,
}

impl Tree {
    fn new(arcs: &[Arc]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(arcs.len()),
            order: (0..arcs.len()).collect(),
        };
        tree.add(arcs, 0..arcs.len());
        tree
    }

    fn add(&mut self, arcs: &[Arc], range: std::ops::Range<usize>) {
        let infinity = Vector2::repeat(f64::INFINITY);
        let own = self.order[range.clone()].iter();
        let bounds = own.fold([infinity, -infinity], |b, k| {
            [b[0].inf(&arcs[*k].bounds[0]), b[1].sup(&arcs[*k].bounds[1])]
        });
        let number = self.nodes.len();
        self.nodes.push(Node {
            bounds,
            arcs: range.clone(),
            second: None,
        });
        if range.len() <= LEAF {
            return;
        }
        let side = bounds[1] - bounds[0];
        let axis = usize::from(side.y > side.x);
        let centre = |k: usize| arcs[k].bounds[0][axis] + arcs[k].bounds[1][axis];
        let half = range.len() / 2;
        self.order[range.clone()].select_nth_unstable_by(half, |a, b| centre(*a).total_cmp(&centre(*b)));
        self.add(arcs, range.start..range.start + half);
        self.nodes[number].second = Some(self.nodes.len());
        self.add(arcs, range.start + half..range.end);
    }
}

pub(super) fn find(arcs: &[Arc], within: f64) -> Found {
    let tree = Tree::new(arcs);
    let (mut found, mut stack) = (Found::default(), Vec::new());
    for (one, arc) in arcs.iter().enumerate() {
        stack.push(0);
        while let Some(k) = stack.pop() {
            let node = &tree.nodes[k];
            if !near(&node.bounds, &arc.bounds, within) {
                continue;
            }
            match node.second {
                Some(second) => stack.extend([k + 1, second]),
                None => {
                    let others = tree.order[node.arcs.clone()].iter().filter(|two| **two > one);
                    others
                        .filter(|two| near(&arcs[**two].bounds, &arc.bounds, within))
                        .for_each(|two| found.look_at_both(arcs, one, *two, within));
                }
            }
        }
    }
    found
}
