//! Triangles filled exactly: corners on a grid of 1/256 of a pixel, and a pixel belongs to a triangle where its centre lies in it, an upper
//! or left edge included. Triangles that share the bits of an edge neither miss nor share a pixel.

use std::ops::Range;

/// Parts of a pixel.
const PARTS: i32 = 256;
/// Columns and rows of a corner, at most: so that products of two in parts fit in 64 bits.
pub(super) const FARTHEST: f64 = 131_072.0;

/// The place at rest as an affine function of column and row, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Affine {
    pub(super) base: [f64; 3],
    pub(super) right: [f64; 3],
    pub(super) down: [f64; 3],
}

/// A corner, in parts of a pixel.
pub(super) type Corner = [i32; 2];

/// The nearest corner of the grid.
#[inline]
pub(super) fn corner(at: [f64; 2]) -> Corner {
    // Added to 1.5 x 2^52, a number below 2^51 leaves its nearest whole number in the lower bits: no call for rounding.
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    at.map(|x| {
        (x * f64::from(PARTS) + ROUNDER)
            .to_bits()
            .wrapping_sub(ROUNDER.to_bits()) as i32
    })
}

/// The surface passes through the piece.
pub(super) const PART: u8 = 1;
/// Tissue turned inside out lies here; what lies over it does not take that away.
pub(super) const FOLDED: u8 = 2;

/// One organ's pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct Canvas {
    size: [usize; 2],
    /// How often each pixel is covered: a triangle counts by its sense, so that slivers turned by the grid take away what they add.
    pub(super) covered: Vec<i16>,
    pub(super) rest: Vec<[f32; 3]>,
    /// [`PART`], [`FOLDED`].
    pub(super) marks: Vec<u8>,
    /// First and last column and row that were touched, the last not included.
    pub(super) touched: [[usize; 2]; 2],
    /// First column and the one after the last of each row of the triangle at hand.
    spans: Vec<[i32; 2]>,
}

impl Canvas {
    /// An empty canvas; it is expected to be all uncovered already where it has this size.
    pub(super) fn begin(&mut self, size: [usize; 2]) {
        if self.size != size {
            let count = size[0] * size[1];
            *self = Self {
                size,
                covered: vec![0; count],
                rest: vec![[0.0; 3]; count],
                marks: vec![0; count],
                touched: [[0; 2]; 2],
                spans: Vec::new(),
            };
        }
        self.touched = [[size[0], 0], [size[1], 0]];
    }

    /// Fills a triangle or a quadrangle; its sense is that of its corners.
    #[inline]
    pub(super) fn fill(&mut self, corners: &[Corner], map: &Affine, marks: u8) {
        let Some(sense) = sense(corners) else {
            // Bent or crossed by the grid: its triangles are not.
            if let [a, b, c, d] = *corners {
                self.fill(&[a, b, c], map, marks);
                self.fill(&[a, c, d], map, marks);
            }
            return;
        };
        let least = corners.iter().fold(i32::MAX, |y, corner| y.min(corner[1]));
        let most = corners.iter().fold(i32::MIN, |y, corner| y.max(corner[1]));
        let rows = rows(least, most, self.size[1]);
        self.spans.clear();
        self.spans.resize(rows.len(), [i32::MAX, i32::MIN]);
        for (k, from) in corners.iter().enumerate() {
            self.edge(*from, corners[(k + 1) % corners.len()], &rows);
        }
        let end = self.size[0] as i32;
        for k in 0..rows.len() {
            let [low, high] = self.spans[k].map(|column| column.clamp(0, end) as usize);
            if low < high {
                self.row(rows.start + k, low..high, map, marks, sense);
            }
        }
    }

    /// Takes up, for each row, the first column whose centre is not left of an edge.
    fn edge(&mut self, from: Corner, to: Corner, rows: &Range<usize>) {
        // Downwards, so that both sides of an edge compute the same.
        let ([x, y], [x_end, y_end]) = if from[1] < to[1] { (from, to) } else { (to, from) };
        let own = self::rows(y, y_end, rows.end);
        let first = own.start.max(rows.start);
        if own.end <= first {
            return;
        }
        // The column is the quotient, rounded up, of (x tall + (256 row - y) wide) by 256 tall, which stays whole from row to row.
        let (wide, tall, parts) = (x_end - x, y_end - y, i64::from(PARTS));
        let (step, more) = (wide.div_euclid(tall), parts * i64::from(wide.rem_euclid(tall)));
        let (wide, tall) = (i64::from(wide), i64::from(tall));
        let by = parts * tall;
        let over = i64::from(x) * tall + (parts * first as i64 - i64::from(y)) * wide + by - 1;
        let (column, mut left) = (over.div_euclid(by), over.rem_euclid(by));
        let mut column = column as i32;
        for span in &mut self.spans[first - rows.start..own.end - rows.start] {
            *span = [span[0].min(column), span[1].max(column)];
            (column, left) = (column + step, left + more);
            if left >= by {
                (column, left) = (column + 1, left - by);
            }
        }
    }

    fn row(&mut self, row: usize, columns: Range<usize>, map: &Affine, marks: u8, sense: i16) {
        let [x, y] = &mut self.touched;
        (x[0], x[1]) = (x[0].min(columns.start), x[1].max(columns.end));
        (y[0], y[1]) = (y[0].min(row), y[1].max(row + 1));
        let start: [f64; 3] = std::array::from_fn(|a| map.base[a] + map.down[a] * row as f64);
        let pixels = row * self.size[0] + columns.start..row * self.size[0] + columns.end;
        let places = self.rest[pixels.clone()].iter_mut();
        let counts = self.covered[pixels.clone()].iter_mut().zip(&mut self.marks[pixels]);
        for ((column, rest), (covered, mark)) in (columns.start..).zip(places).zip(counts) {
            // Collapsed tissue may lie there more often than a count holds: many is enough.
            *covered = covered.saturating_add(sense);
            *mark = *mark & FOLDED | marks;
            let column = column as f64;
            *rest = [
                (start[0] + map.right[0] * column) as f32,
                (start[1] + map.right[1] * column) as f32,
                (start[2] + map.right[2] * column) as f32,
            ];
        }
    }
}

/// The sense of a polygon that turns one way at all its corners; none where it does not, or has no area.
fn sense(corners: &[Corner]) -> Option<i16> {
    let (mut left, mut right) = (false, false);
    for (k, b) in corners.iter().enumerate() {
        let a = corners[(k + corners.len() - 1) % corners.len()];
        let c = corners[(k + 1) % corners.len()];
        let [from, to] = [[a, *b], [*b, c]].map(|[p, q]| [0, 1].map(|axis| i64::from(q[axis]) - i64::from(p[axis])));
        let turn = from[0] * to[1] - from[1] * to[0];
        (left, right) = (left || turn < 0, right || turn > 0);
    }
    match (left, right) {
        (false, true) => Some(1),
        (true, false) => Some(-1),
        _ => None,
    }
}

/// The rows whose centres lie from the one to the other, the last not included.
fn rows(least: i32, most: i32, end: usize) -> Range<usize> {
    let whole = |y: i32| (y + PARTS - 1).div_euclid(PARTS).clamp(0, end as i32) as usize;
    whole(least)..whole(most)
}
