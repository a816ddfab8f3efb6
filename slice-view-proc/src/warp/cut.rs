//! A piece cut by the plane: six tetrahedra about its diagonal, each cut in a triangle or a quadrangle.

use super::edge::{Corner, crossing};
use super::raster::{Affine, Canvas, FOLDED, PART};

/// The axes along which each tetrahedron goes from the lowest corner to the highest, and whether that order is an even one.
const PATHS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([0, 2, 1], false),
    ([2, 1, 0], false),
    ([1, 0, 2], false),
];

/// A piece: its corners in the plane's frame, and where its lowest corner is at rest, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) corners: [[f64; 3]; 8],
    pub(super) low: [f64; 3],
    pub(super) side: f64,
    /// Whether the organ's surface passes through it.
    pub(super) part: bool,
}

impl Piece {
    /// Draws the cut; the largest stretch from now to rest, mm a mm, of the tetrahedra that were cut.
    #[inline]
    pub(super) fn draw(&self, pixel_mm: f64, canvas: &mut Canvas) -> f64 {
        let mut most = 0.0_f64;
        for (axes, even) in PATHS {
            let first = 1 << axes[0];
            let path = [0, first, first | 1 << axes[1], 7];
            let behind = path.map(|k| self.corners[k][2] >= 0.0);
            if behind == [behind[0]; 4] {
                continue;
            }
            let Some((map, stretch, folded)) = self.map(&path, axes, pixel_mm) else {
                continue;
            };
            most = most.max(stretch);
            let marks = if self.part { PART } else { 0 } | if folded { FOLDED } else { 0 };
            // Positively oriented at rest.
            let order = if even {
                path
            } else {
                [path[0], path[1], path[3], path[2]]
            };
            let (polygon, count) = self.polygon(order);
            canvas.fill(&polygon[..count], &map, marks);
        }
        most.sqrt()
    }

    /// The place at rest by column and row, from the edges along the path, with the square of its stretch, and whether tissue is turned inside out; none where
    /// the edges span nothing.
    fn map(&self, path: &[usize; 4], axes: [usize; 3], pixel_mm: f64) -> Option<(Affine, f64, bool)> {
        let mut edges = [[0.0; 3]; 3];
        for (k, axis) in axes.into_iter().enumerate() {
            let (from, to) = (self.corners[path[k]], self.corners[path[k + 1]]);
            edges[axis] = std::array::from_fn(|a| to[a] - from[a]);
        }
        let (rows, volume) = inverse(&edges)?;
        let from = self.corners[0];
        let scaled = rows.map(|row| row.map(|x| x * self.side));
        let [right, down] = [0, 1].map(|k| scaled.map(|row| row[k]));
        let base = std::array::from_fn(|a| {
            let back: f64 = (0..3).map(|k| scaled[a][k] * from[k]).sum();
            self.low[a] - back
        });
        let square = |k: usize| scaled.iter().map(|row| row[k] * row[k]).sum::<f64>();
        let stretch = (square(0) + square(1)) / (pixel_mm * pixel_mm) + square(2);
        Some((Affine { base, right, down }, stretch, volume < 0.0))
    }

    /// The cut of a tetrahedron, in the sense that it has in the image where tissue is not turned inside out.
    fn polygon(&self, order: [usize; 4]) -> ([Corner; 4], usize) {
        let front = order.map(|k| self.corners[k][2] < 0.0);
        let [a, b, c, d] = order;
        let cut = |p: usize, q: usize| crossing(&self.corners[p.min(q)], &self.corners[p.max(q)]);
        let three = |p, [q, r, s]: [usize; 3]| ([cut(p, q), cut(p, r), cut(p, s), [0; 2]], 3);
        // Two before the plane, two behind it, in an even order.
        let four = |[p, q]: [usize; 2], [r, s]: [usize; 2]| ([cut(p, r), cut(p, s), cut(q, s), cut(q, r)], 4);
        match front {
            [true, false, false, false] => three(a, [b, c, d]),
            [false, true, true, true] => three(a, [b, d, c]),
            [false, true, false, false] => three(b, [a, d, c]),
            [true, false, true, true] => three(b, [a, c, d]),
            [false, false, true, false] => three(c, [a, b, d]),
            [true, true, false, true] => three(c, [a, d, b]),
            [false, false, false, true] => three(d, [a, c, b]),
            [true, true, true, false] => three(d, [a, b, c]),
            [true, true, false, false] => four([a, b], [c, d]),
            [false, false, true, true] => four([c, d], [a, b]),
            [true, false, true, false] => four([a, c], [d, b]),
            [false, true, false, true] => four([d, b], [a, c]),
            [true, false, false, true] => four([a, d], [b, c]),
            [false, true, true, false] => four([b, c], [a, d]),
            _ => ([[0; 2]; 4], 0),
        }
    }
}

/// The inverse of the matrix with these columns, by rows, and their determinant.
pub(super) fn inverse(columns: &[[f64; 3]; 3]) -> Option<([[f64; 3]; 3], f64)> {
    let [a, b, c] = columns;
    let cross = |p: &[f64; 3], q: &[f64; 3]| {
        [
            p[1] * q[2] - p[2] * q[1],
            p[2] * q[0] - p[0] * q[2],
            p[0] * q[1] - p[1] * q[0],
        ]
    };
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let volume: f64 = (0..3).map(|k| a[k] * rows[0][k]).sum();
    let part = 1.0 / volume;
    let found = rows.map(|row| row.map(|x| x * part));
    found.iter().flatten().all(|x| x.is_finite()).then_some((found, volume))
}
