//! The corners of pieces where they lie now. Each is computed once, by the first cube that asks: all pieces about it share its bits, those
//! of a larger neighbour too, whose own sum would round differently.

use super::placed::Placed;
use super::quadratic::{at, weights};
use super::shape::Shape;

/// Corners of one organ, in the plane's frame: columns, rows, mm behind the plane.
#[derive(Debug, Clone, Default)]
pub(super) struct Lattice {
    round: u32,
    /// The round in which each corner was computed.
    rounds: Vec<u32>,
    corners: Vec<[f64; 3]>,
    dims: [i32; 3],
}

impl Lattice {
    /// Forgets what was computed.
    pub(super) fn begin(&mut self, shape: &Shape) {
        let count: usize = shape.corners.iter().map(|n| n.unsigned_abs() as usize).product();
        self.dims = shape.corners;
        // Of a smaller organ before this one, or too few rounds left; else what was computed for another is of another round.
        if self.rounds.len() < count || self.round == u32::MAX {
            self.rounds = vec![0; count];
            self.corners = vec![[0.0; 3]; count];
            self.round = 0;
        }
        self.round += 1;
    }

    /// The eight corners of a piece of `cube`, whose nodes lie at `nodes`: bit 0 of a corner's number is its step along x, and so on.
    #[inline]
    pub(super) fn piece(&mut self, cube: &Placed, nodes: &[[f64; 3]; 27], low: [i32; 3]) -> [[f64; 3]; 8] {
        std::array::from_fn(|k| self.corner(cube, nodes, [0, 1, 2].map(|a| low[a] + (k >> a & 1) as i32)))
    }

    /// A corner of a piece, counted from the cube's.
    #[inline(always)]
    pub(super) fn corner(&mut self, cube: &Placed, nodes: &[[f64; 3]; 27], corner: [i32; 3]) -> [f64; 3] {
        let ([x, y, z], [i, j, k]) = (cube.corner, corner);
        let (x, y, z) = (x + i, y + j, z + k);
        let [nx, ny, _] = self.dims;
        let place = (x + nx * (y + ny * z)) as usize;
        if self.rounds[place] != self.round {
            self.rounds[place] = self.round;
            self.corners[place] = computed(cube.span, nodes, corner);
        }
        self.corners[place]
    }
}

fn computed(span: i32, nodes: &[[f64; 3]; 27], corner: [i32; 3]) -> [f64; 3] {
    // At a node the polynomials are exactly 1 and 0.
    if corner.iter().all(|k| 2 * k % span == 0) {
        let [x, y, z] = corner.map(|k| (2 * k / span) as usize);
        return nodes[x + 3 * y + 9 * z];
    }
    let part = |a: usize| f64::from(corner[a]) / f64::from(span);
    at(nodes, &[0, 1, 2].map(|a| weights(part(a))))
}
