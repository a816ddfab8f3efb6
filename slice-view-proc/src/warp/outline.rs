//! The border of a part of a cube in the image: where the plane cuts its faces, row by row.

use super::corners::Corners;
use super::edge::{Corner, Edge, crossing};
use super::faces::FACES;
use super::placed::Held;

/// Pieces along an axis of a cube that is drawn whole, at most: beyond, they are as small as the grid would be.
pub(super) const MOST_SPAN: i32 = 8;
/// Corners of them.
const ACROSS: usize = MOST_SPAN as usize + 1;
/// Crossings of a row, at most.
const MOST: usize = 8;

/// A row: the first columns that are not left of an edge, and by how much the count changes there, as one number each: [`crossing_at`].
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    count: usize,
    at: [i64; MOST],
}

/// A column in the upper bits, so that they sort by it, with a change.
#[inline(always)]
fn crossing_at(column: i32, change: i8) -> i64 {
    i64::from(column) << 8 | i64::from(change as u8)
}

/// Rows of the image with what of them lies within.
#[derive(Debug, Clone, Default)]
pub(super) struct Outline {
    rows: Vec<Row>,
    /// Touched rows, the last not included.
    first: usize,
    end: usize,
    full: bool,
}

impl Outline {
    /// An empty one, in an image of so many rows.
    pub(super) fn begin(&mut self, rows: usize) {
        if self.rows.len() != rows {
            *self = Self::default();
            self.rows.resize(rows, Row::default());
        }
        for row in self.rows.get_mut(self.first..self.end).unwrap_or_default() {
            row.count = 0;
        }
        (self.first, self.end, self.full) = (rows, 0, false);
    }

    /// Takes up the faces of those pieces that hold `wanted`, where a piece that does not, or the cube, ends.
    pub(super) fn trace(&mut self, corners: &mut Corners<'_>, wanted: Held) {
        let span = corners.cube.span;
        if span == 2 {
            self.trace_eight(corners, wanted);
            return;
        }
        for axis in 0..3 {
            for along in 0..=span {
                // Between pieces that are all alike nothing ends.
                let is_inner = 0 < along && along < span;
                if !(is_inner && corners.cube.uniform.is_some()) && corners.may_cut(axis, along) {
                    self.sheet(corners, (axis, along), wanted);
                }
            }
        }
    }

    /// The faces of pieces in one plane of a cube's lattice, across `axis` and so many pieces along it.
    fn sheet(&mut self, corners: &mut Corners<'_>, (axis, along): (usize, i32), wanted: Held) {
        let span = corners.cube.span;
        let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
        let place = |a: i32, b: i32, c: i32| {
            let mut at = [a; 3];
            (at[one], at[other]) = (b, c);
            at
        };
        // Each corner is looked up once, not by all faces about it.
        let (row, mut seen) = (span as usize + 1, [[0.0; 3]; ACROSS * ACROSS]);
        for c in 0..=span {
            for b in 0..=span {
                seen[c as usize * row + b as usize] = corners.at(place(along, b, c));
            }
        }
        let holds = |a, b, c| (0..span).contains(&a) && corners.cube.held(place(a, b, c)) == wanted;
        for c in 0..span {
            for b in 0..span {
                let low = c as usize * row + b as usize;
                let four = [low, low + 1, low + row, low + row + 1].map(|k| &seen[k]);
                let behind = four.map(|corner| corner[2] >= 0.0);
                if behind == [behind[0]; 4] {
                    continue;
                }
                let [below, above] = [holds(along - 1, b, c), holds(along, b, c)];
                if below != above {
                    self.cut(four, above);
                }
            }
        }
    }

    /// The same of a cube of eight pieces.
    #[inline(always)]
    fn trace_eight(&mut self, corners: &Corners<'_>, wanted: Held) {
        let held = |k: u8| u8::from(corners.cube.held([k & 1, k >> 1 & 1, k >> 2].map(i32::from)) == wanted) << k;
        let held = match corners.cube.uniform {
            Some(_) => 0xFF,
            None => (0..8).fold(0, |bits, k| bits | held(k)),
        };
        for face in &FACES {
            let behind = corners.behind & face.bits;
            let [below, above] = face.pieces.map(|piece| piece & held != 0);
            if behind == 0 || behind == face.bits || below == above {
                continue;
            }
            let [low, right, up, high] = face.corners;
            let few = &corners.few;
            self.cut([&few[low], &few[right], &few[up], &few[high]], above);
        }
    }

    /// The two triangles of a face, divided as the pieces' tetrahedra divide it; `flip` where it is a piece's lower one.
    #[inline(always)]
    fn cut(&mut self, [low, right, up, high]: [&[f64; 3]; 4], flip: bool) {
        let behind = [low[2] >= 0.0, right[2] >= 0.0, up[2] >= 0.0, high[2] >= 0.0];
        if let Some([from, to]) = cut([low, right, high], [behind[0], behind[1], behind[3]], [0, 1, 2]) {
            self.edge(from, to, flip);
        }
        if let Some([from, to]) = cut([low, up, high], [behind[0], behind[2], behind[3]], [0, 1, 2]) {
            self.edge(from, to, !flip);
        }
    }

    /// Takes up an edge; `turned` where it runs the other way about.
    #[inline(always)]
    fn edge(&mut self, from: Corner, to: Corner, turned: bool) {
        let down = (from[1] < to[1]) != turned;
        let Some((first, edge)) = Edge::new(from, to, 0, self.rows.len()) else {
            return;
        };
        let sense = if down { 1 } else { -1 };
        let end = first + edge.rows;
        (self.first, self.end) = (self.first.min(first), self.end.max(end));
        for (row, column) in self.rows[first..end].iter_mut().zip(edge) {
            if row.count == MOST {
                self.full = true;
                return;
            }
            row.at[row.count] = crossing_at(column, sense);
            row.count += 1;
        }
    }

    /// Puts the crossings of all rows in order.
    #[inline(always)]
    pub(super) fn close(&mut self) {
        for row in self.rows.get_mut(self.first..self.end).unwrap_or_default() {
            if row.count == 2 {
                let [a, b, ..] = row.at;
                (row.at[0], row.at[1]) = (a.min(b), a.max(b));
            } else {
                row.at[..row.count].sort_unstable();
            }
        }
    }

    /// Whether there are more crossings than a row holds: the outline is of no use.
    pub(super) fn is_full(&self) -> bool {
        self.full
    }

    /// Touched rows.
    pub(super) fn rows(&self) -> std::ops::Range<usize> {
        self.first.min(self.end)..self.end
    }

    /// The columns from the first to the one after the last of a row, within an image of `width`; without any the first is not lower.
    #[inline(always)]
    pub(super) fn extent(outlines: &[Self; 2], row: usize, width: usize) -> [usize; 2] {
        let (mut low, mut high) = (width as i32, 0);
        for outline in outlines {
            let row = &outline.rows[row];
            if row.count > 0 {
                low = low.min((row.at[0] >> 8) as i32);
                high = high.max((row.at[(row.count - 1) % MOST] >> 8) as i32);
            }
        }
        [low.max(0) as usize, high.min(width as i32) as usize]
    }

    /// The runs of a row's pixels within an image of `width`.
    #[inline(always)]
    pub(super) fn runs(&self, row: usize, width: usize) -> Runs<'_> {
        let row = &self.rows[row];
        Runs {
            left: &row.at[..row.count],
            sense: 0,
            width: width as i32,
        }
    }
}

/// Pixels of a row, from the first column to the one after the last, and how often they count.
pub(super) struct Run {
    pub(super) columns: [usize; 2],
    pub(super) sense: i8,
}

/// Those of a row.
pub(super) struct Runs<'a> {
    left: &'a [i64],
    sense: i8,
    width: i32,
}

impl Iterator for Runs<'_> {
    type Item = Run;

    #[inline(always)]
    fn next(&mut self) -> Option<Run> {
        while let [low, rest @ ..] = self.left {
            self.left = rest;
            self.sense += *low as i8;
            let column = |at: i64| ((at >> 8) as i32).max(0).min(self.width);
            let (low, high) = (column(*low), column(*rest.first()?));
            if self.sense != 0 && low < high {
                return Some(Run {
                    columns: [low as usize, high as usize],
                    sense: self.sense,
                });
            }
        }
        None
    }
}

/// Where the plane cuts a triangle whose corners ascend along all axes, from where it passes to the far side to where it comes back.
#[inline(always)]
fn cut(at: [&[f64; 3]; 3], behind: [bool; 3], [a, b, c]: [usize; 3]) -> Option<[Corner; 2]> {
    let cross = |p: usize, q: usize| crossing(at[p.min(q)], at[p.max(q)]);
    let lone = |p: usize, next: usize, last: usize| {
        let ends = [cross(p, next), cross(last, p)];
        if behind[p] { [ends[1], ends[0]] } else { ends }
    };
    match [behind[0], behind[1], behind[2]] {
        [p, q, r] if q == r && p != q => Some(lone(a, b, c)),
        [p, q, r] if p == r && p != q => Some(lone(b, c, a)),
        [p, q, r] if p == q && q != r => Some(lone(c, a, b)),
        _ => None,
    }
}
