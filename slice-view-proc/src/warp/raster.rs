//! Triangles filled exactly: corners on a grid of 1/256 of a pixel, and a pixel belongs to a triangle where its centre lies in it, an upper
//! or left edge included. Triangles that share the bits of an edge neither miss nor share a pixel.

use std::ops::Range;

use super::edge::{Corner, Edge, rows};

/// Columns and rows of a corner, at most: so that products of two in parts fit in 64 bits.
pub(super) const FARTHEST: f64 = 131_072.0;

/// The place at rest as an affine function of column and row, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Affine {
    pub(super) base: [f64; 3],
    pub(super) right: [f64; 3],
    pub(super) down: [f64; 3],
}

/// The surface passes through the piece.
pub(super) const PART: u8 = 1;
/// Tissue turned inside out lies here; what lies over it does not take that away.
pub(super) const FOLDED: u8 = 2;

/// One organ's pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct Canvas {
    pub(super) size: [usize; 2],
    /// How often each pixel is covered: a triangle counts by its sense, so that slivers turned by the grid take away what they add. A signed
    /// number's bits.
    pub(super) covered: Vec<u8>,
    pub(super) rest: Vec<[f32; 3]>,
    /// [`PART`], [`FOLDED`].
    pub(super) marks: Vec<u8>,
    /// First and last column of each row that were touched, the last not included.
    pub(super) touched: Vec<[usize; 2]>,
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
                touched: vec![[usize::MAX, 0]; size[1]],
                spans: Vec::new(),
            };
        }
        self.touched.fill([usize::MAX, 0]);
    }

    /// Counts the columns of a row from the one to the other.
    #[inline(always)]
    pub(super) fn count(&mut self, row: usize, [low, high]: [usize; 2], marks: u8, sense: i8) {
        let touched = &mut self.touched[row];
        *touched = [touched[0].min(low), touched[1].max(high)];
        let (low, high) = (row * self.size[0] + low, row * self.size[0] + high);
        let covered = self.covered.as_chunks_mut::<8>().0;
        let marked = self.marks.as_chunks_mut::<8>().0;
        let (first, last) = (low / 8, (high - 1) / 8);
        let (since, until) = (FROM[low % 8], !FROM[(high - 1) % 8 + 1]);
        for k in first..=last {
            let (Some(covered), Some(marked)) = (covered.get_mut(k), marked.get_mut(k)) else {
                self.count_each(low.max(8 * k), high, marks, sense);
                return;
            };
            let on = if k == first { since } else { u64::MAX } & if k == last { until } else { u64::MAX };
            let before = u64::from_le_bytes(*covered);
            if before & on == 0 {
                *covered = (before | on & eight(sense as u8)).to_le_bytes();
                let kept = u64::from_le_bytes(*marked) & (eight(FOLDED) | !on);
                *marked = (kept | on & eight(marks)).to_le_bytes();
                continue;
            }
            for (j, on) in on.to_le_bytes().into_iter().enumerate() {
                if on != 0 {
                    count(&mut covered[j], &mut marked[j], marks, sense);
                }
            }
        }
    }

    /// The same one by one, of the last pixels of the image.
    #[cold]
    fn count_each(&mut self, low: usize, high: usize, marks: u8, sense: i8) {
        for (covered, mark) in self.covered[low..high].iter_mut().zip(&mut self.marks[low..high]) {
            count(covered, mark, marks, sense);
        }
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
    #[inline(always)]
    fn edge(&mut self, from: Corner, to: Corner, rows: &Range<usize>) {
        let Some((first, edge)) = Edge::new(from, to, rows.start, rows.end) else {
            return;
        };
        for (span, column) in self.spans[first - rows.start..][..edge.rows].iter_mut().zip(edge) {
            *span = [span[0].min(column), span[1].max(column)];
        }
    }

    fn row(&mut self, row: usize, columns: Range<usize>, map: &Affine, marks: u8, sense: i8) {
        self.count(row, [columns.start, columns.end], marks, sense);
        let start: [f64; 3] = std::array::from_fn(|a| map.base[a] + map.down[a] * row as f64);
        let pixels = row * self.size[0] + columns.start..row * self.size[0] + columns.end;
        for (column, rest) in columns.zip(&mut self.rest[pixels]) {
            let column = column as f64;
            *rest = [
                (start[0] + map.right[0] * column) as f32,
                (start[1] + map.right[1] * column) as f32,
                (start[2] + map.right[2] * column) as f32,
            ];
        }
    }
}

/// All ones from a byte on.
const FROM: [u64; 9] = [
    u64::MAX,
    u64::MAX << 8,
    u64::MAX << 16,
    u64::MAX << 24,
    u64::MAX << 32,
    u64::MAX << 40,
    u64::MAX << 48,
    u64::MAX << 56,
    0,
];

#[inline(always)]
fn count(covered: &mut u8, mark: &mut u8, marks: u8, sense: i8) {
    // Collapsed tissue may lie there more often than a count holds: many is enough.
    *covered = (*covered as i8).saturating_add(sense) as u8;
    *mark = *mark & FOLDED | marks;
}

/// Eight of one byte.
const fn eight(byte: u8) -> u64 {
    u64::from_ne_bytes([byte; 8])
}

/// The sense of a polygon that turns one way at all its corners; none where it does not, or has no area.
fn sense(corners: &[Corner]) -> Option<i8> {
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
