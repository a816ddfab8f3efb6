//! A part of a graph in two, by few vertices between them.

use super::super::graph::Graph;
use super::cover::{Cover, Sides, smallest_cover};

/// Where cuts are tried: these parts of the weight lie before them.
const PARTS_BEFORE: [f64; 7] = [0.5, 0.46, 0.54, 0.42, 0.58, 0.37, 0.63];
/// A side with more of the weight than this is no half.
const MOST_OF_ONE_SIDE: f64 = 0.8;

/// Two parts without an edge between them, and what lies between.
#[derive(Debug, Clone, Default)]
pub(super) struct Cut {
    pub(super) sides: [Vec<u32>; 2],
    pub(super) between: Vec<u32>,
    /// Which of the directions it goes across.
    pub(super) direction: usize,
    /// Less is better.
    pub(super) cost: f64,
}

/// Looks for cuts of parts of one graph.
pub(super) struct Cutter<'a> {
    graph: &'a Graph,
    weights: &'a [usize],
    /// Of each vertex: the side of the cut that is tried, or none.
    side: Vec<Side>,
    /// Of each vertex at a cut: its number on its side.
    number: Vec<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Outside,
    First,
    Second,
}

impl<'a> Cutter<'a> {
    pub(super) fn new(graph: &'a Graph, weights: &'a [usize]) -> Self {
        Self {
            graph,
            weights,
            side: vec![Side::Outside; graph.size()],
            number: vec![0; graph.size()],
        }
    }

    /// The best cut of a part across one of the directions: along each, a number by vertex of the part. `None` where no cut
    /// leaves two halves.
    pub(super) fn best(&mut self, part: &[u32], directions: &[Vec<f64>]) -> Option<Cut> {
        let mut best: Option<Cut> = None;
        for (direction, along) in directions.iter().enumerate() {
            let mut order: Vec<usize> = (0..part.len()).collect();
            // Equal numbers by vertex: the result depends on nothing else.
            order.sort_by(|a, b| along[*a].total_cmp(&along[*b]).then(part[*a].cmp(&part[*b])));
            for position in self.positions(part, along, &order) {
                let cut = self.at(part, &order, position);
                // Strictly less: an infinite cost never gets in, and of equal cuts the first stays.
                let better = cut.cost < best.as_ref().map_or(f64::INFINITY, |b| b.cost);
                if better {
                    best = Some(Cut { direction, ..cut });
                }
            }
        }
        best
    }

    /// Places of cuts in the order, between unequal numbers, near the middle of the weight.
    fn positions(&self, part: &[u32], along: &[f64], order: &[usize]) -> Vec<usize> {
        let whole: usize = part.iter().map(|i| self.weights[*i as usize]).sum();
        let mut steps = Vec::new();
        let mut before = 0;
        for k in 1..order.len() {
            before += self.weights[part[order[k - 1]] as usize];
            // Vertices of one plane stay together: only their numbers would part them.
            if along[order[k - 1]] < along[order[k]] {
                steps.push((before as f64 / whole as f64, k));
            }
        }
        let mut found = Vec::new();
        for aim in PARTS_BEFORE {
            let nearest = steps
                .iter()
                .min_by(|a, b| (a.0 - aim).abs().total_cmp(&(b.0 - aim).abs()));
            if let Some(&(_, k)) = nearest
                && !found.contains(&k)
            {
                found.push(k);
            }
        }
        found
    }

    /// The cut before a place of the order.
    fn at(&mut self, part: &[u32], order: &[usize], position: usize) -> Cut {
        for (k, i) in order.iter().enumerate() {
            self.side[part[*i] as usize] = if k < position { Side::First } else { Side::Second };
        }
        let [first, second] = [Side::First, Side::Second].map(|side| self.edge(part, side));
        // Smallest covers are rarely the only ones: taken from the other side, one may leave evener halves.
        let forth = self.cut(part, &first, &second, false);
        let back = self.cut(part, &second, &first, true);
        part.iter().for_each(|i| self.side[*i as usize] = Side::Outside);
        if back.cost < forth.cost { back } else { forth }
    }

    /// The vertices of one side with a neighbour on the other.
    fn edge(&self, part: &[u32], own: Side) -> Vec<u32> {
        let other = if own == Side::First { Side::Second } else { Side::First };
        let at_edge = |i: &&u32| {
            let near = self.graph.of(**i as usize);
            self.side[**i as usize] == own && near.iter().any(|j| self.side[*j as usize] == other)
        };
        part.iter().filter(at_edge).copied().collect()
    }

    /// The cut that takes the fewest vertices from both sides of an edge; of several, most from `left`.
    fn cut(&mut self, part: &[u32], left: &[u32], right: &[u32], swapped: bool) -> Cut {
        // Only numbers at the other side's edge are read, all of which are set here: old ones do no harm.
        for (k, i) in right.iter().enumerate() {
            self.number[*i as usize] = k as u32;
        }
        let other = if swapped { Side::First } else { Side::Second };
        let across = |i: &u32| {
            let near = self.graph.of(*i as usize).iter();
            near.filter(|j| self.side[**j as usize] == other)
                .map(|j| self.number[*j as usize])
                .collect()
        };
        // Every edge across has to lose an end: a smallest cover does it with the fewest vertices.
        let Cover {
            left: taken,
            right: also,
        } = smallest_cover(&Sides {
            left: left.iter().map(across).collect(),
            right: right.len(),
        });
        let chosen = |list: &[u32], taken: &[bool]| -> Vec<u32> {
            let pairs = list.iter().zip(taken);
            pairs.filter(|(_, taken)| **taken).map(|(i, _)| *i).collect()
        };
        let mut between = chosen(left, &taken);
        between.extend(chosen(right, &also));
        between.sort_unstable();
        self.apart(part, between)
    }

    /// The two sides without what lies between.
    fn apart(&self, part: &[u32], between: Vec<u32>) -> Cut {
        let mut cut = Cut {
            between,
            ..Cut::default()
        };
        let mut weight = [0_usize; 2];
        for &i in part {
            if cut.between.binary_search(&i).is_ok() {
                continue;
            }
            let k = usize::from(self.side[i as usize] == Side::Second);
            weight[k] += self.weights[i as usize];
            cut.sides[k].push(i);
        }
        let between: usize = cut.between.iter().map(|i| self.weights[*i as usize]).sum();
        cut.cost = cost(weight, between);
        cut
    }
}

/// What a cut is worth: less is better; infinite where it leaves no two halves.
fn cost(sides: [usize; 2], between: usize) -> f64 {
    let [a, b] = sides.map(|w| w as f64);
    let (s, whole) = (between as f64, a + b + between as f64);
    if a.max(b) > MOST_OF_ONE_SIDE * whole || a.min(b) == 0.0 {
        return f64::INFINITY;
    }
    // What lies between becomes a dense front and counts most; halves that differ a little cost next to nothing.
    let unlike = (a - b).abs() / (a + b);
    s * (1.0 + unlike * unlike)
}
