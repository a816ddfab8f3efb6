//! Boundaries: closed contours of quadratic arcs.

use nalgebra::Vector2;

use crate::q9::Arc;

/// The boundary of a solid: arcs of three nodes each (II 3.14), the solid on their left.
#[derive(Debug, Clone)]
pub struct Boundary {
    /// The nodes of each arc, by the solid's own numbers.
    pub arcs: Vec<Arc>,
    /// The arc that begins where each one ends.
    pub next: Vec<usize>,
    /// The arc that ends where each one begins.
    pub previous: Vec<usize>,
    /// Reference positions of the nodes of each arc.
    pub reference: Vec<[Vector2<f64>; 3]>,
    /// Every node of the arcs once.
    pub nodes: Vec<usize>,
    /// True where every arc is and stays a segment: its ends say all of it.
    pub straight: bool,
    extent: f64,
}

impl Boundary {
    /// The boundary of these arcs, with the reference position of each node.
    pub(crate) fn new(arcs: Vec<Arc>, position: impl Fn(usize) -> Vector2<f64>) -> Self {
        let begins: std::collections::BTreeMap<usize, usize> =
            arcs.iter().enumerate().map(|(k, a)| (a[0], k)).collect();
        // Each arc goes on where another begins at its end node; an open end goes on to itself.
        let next: Vec<usize> = arcs
            .iter()
            .enumerate()
            .map(|(k, arc)| begins.get(&arc[2]).copied().unwrap_or(k))
            .collect();
        let mut previous: Vec<usize> = (0..arcs.len()).collect();
        for (k, n) in next.iter().enumerate() {
            previous[*n] = k;
        }
        let mut nodes: Vec<usize> = arcs.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let reference: Vec<[Vector2<f64>; 3]> = arcs.iter().map(|arc| arc.map(&position)).collect();
        Self {
            extent: extent(&reference),
            arcs,
            next,
            previous,
            reference,
            nodes,
            straight: false,
        }
    }

    /// The largest side of the box round the reference positions.
    pub fn extent(&self) -> f64 {
        self.extent
    }
}

fn extent(reference: &[[Vector2<f64>; 3]]) -> f64 {
    let points = || reference.iter().flatten();
    let low = points().fold(Vector2::repeat(f64::INFINITY), |m, p| m.inf(p));
    let high = points().fold(Vector2::repeat(f64::NEG_INFINITY), |m, p| m.sup(p));
    (high - low).amax()
}
