//! Places at rest on a coarse grid of an image's pixels, and between them.

use super::inverse::{Map, Nodes};
use super::outline::Outline;
use super::raster::Canvas;

/// Every so many pixels along columns and rows lies a node; between nodes a place is bilinear.
#[derive(Debug, Clone, Default)]
pub(super) struct Sheet {
    tile: usize,
    first_row: usize,
    /// The first node's column and row, in nodes, and nodes a row.
    first: [usize; 2],
    width: usize,
    /// Columns of nodes that are needed, by row of nodes.
    needed: Vec<[usize; 2]>,
    pub(super) nodes: Nodes,
    /// By row of nodes three numbers a node, and the row at hand between two; rows are whole groups of eight.
    places: Vec<f32>,
    line: Vec<f32>,
    stride: usize,
}

impl Sheet {
    /// Lays nodes under `outlines`, in an image of `width` columns; whether there are any.
    #[inline(always)]
    pub(super) fn lay(&mut self, outlines: &[Outline; 2], tile: usize, width: usize, map: &Map) -> bool {
        let [a, b] = [outlines[0].rows(), outlines[1].rows()];
        let rows = match (a.is_empty(), b.is_empty()) {
            (true, true) => return false,
            (false, true) => a,
            (true, false) => b,
            (false, false) => a.start.min(b.start)..a.end.max(b.end),
        };
        // Of single pixels no node beyond the last is needed.
        let (more, shift) = (usize::from(tile > 1), tile.trailing_zeros());
        let first_row = rows.start >> shift;
        let count = ((rows.end - 1) >> shift) - first_row + 1 + more;
        self.tile = tile;
        self.needed.clear();
        self.needed.resize(count, [usize::MAX, 0]);
        self.first_row = rows.start;
        let (mut low, mut high) = (usize::MAX, 0);
        for row in rows {
            let own = (row >> shift) - first_row;
            let [least, most] = Outline::extent(outlines, row, width);
            if least < most {
                let needed = [least >> shift, ((most - 1) >> shift) + 1 + more];
                (low, high) = (low.min(needed[0]), high.max(needed[1]));
                for own in &mut self.needed[own..=own + more] {
                    *own = [own[0].min(needed[0]), own[1].max(needed[1])];
                }
            }
        }
        if low >= high {
            return false;
        }
        self.first = [low, first_row];
        self.width = high - low;
        self.pixels(map);
        true
    }

    /// The nodes' pixels, relative to the map's middle.
    #[inline(always)]
    fn pixels(&mut self, map: &Map) {
        let [columns, rows] = &mut self.nodes.pixels;
        columns.clear();
        rows.clear();
        for (k, [low, high]) in self.needed.iter().enumerate() {
            let row = ((self.first[1] + k) * self.tile) as i32;
            for node in *low..*high {
                let [column, row] = map.relative((node * self.tile) as i32, row);
                columns.push(column);
                rows.push(row);
            }
        }
        let whole = columns.len().next_multiple_of(8);
        let [column, row] = [&*columns, &*rows].map(|of| of.last().copied().unwrap_or(0.0));
        columns.resize(whole, column);
        rows.resize(whole, row);
        for places in &mut self.nodes.places {
            places.resize(whole, 0.0);
        }
    }

    /// Takes over the nodes' places, which are multiples of `half` from `middle`.
    #[inline(always)]
    pub(super) fn take(&mut self, middle: [f64; 3], half: f64) {
        // Some more, as what is beside the last is read.
        self.stride = (3 * self.width + 8).next_multiple_of(8);
        self.line.resize(self.stride, 0.0);
        self.places.resize(self.stride * self.needed.len(), 0.0);
        let (x, y, z, half) = (middle[0] as f32, middle[1] as f32, middle[2] as f32, half as f32);
        let [us, vs, ws] = &self.nodes.places;
        let mut found = us.iter().zip(vs).zip(ws);
        for (k, [low, high]) in self.needed.iter().enumerate() {
            if low >= high {
                continue;
            }
            let begin = k * self.stride + 3 * (low - self.first[0]);
            let (own, _) = self.places[begin..begin + 3 * (high - low)].as_chunks_mut::<3>();
            for (place, ((u, v), w)) in own.iter_mut().zip(&mut found) {
                *place = [x + half * u, y + half * v, z + half * w];
            }
        }
    }

    /// Draws what lies within outlines, each with its marks.
    #[inline(always)]
    pub(super) fn draw(&mut self, outlines: &[Outline; 2], marks: [u8; 2], canvas: &mut Canvas) {
        let end = outlines[0].rows().end.max(outlines[1].rows().end);
        for row in self.first_row..end {
            self.interpolate(row);
            for (outline, marks) in outlines.iter().zip(marks) {
                for run in outline.runs(row, canvas.size[0]) {
                    canvas.count(row, run.columns, marks, run.sense);
                    self.write(row, run.columns, canvas);
                }
            }
        }
    }

    /// The places of a row at its columns of nodes.
    #[inline(always)]
    fn interpolate(&mut self, row: usize) {
        let shift = self.tile.trailing_zeros();
        let (k, part) = ((row >> shift) - self.first[1], row & (self.tile - 1));
        let part = part as f32 * (1.0 / self.tile as f32);
        let own = &self.places[k * self.stride..][..self.stride];
        // After the last row there is none: of single pixels none is needed.
        let next = self
            .places
            .get((k + 1) * self.stride..)
            .and_then(|rest| rest.get(..self.stride));
        let (own, next) = (own.as_chunks::<8>().0, next.unwrap_or(own).as_chunks::<8>().0);
        for ((line, a), b) in self.line.as_chunks_mut::<8>().0.iter_mut().zip(own).zip(next) {
            for k in 0..8 {
                line[k] = a[k] + (b[k] - a[k]) * part;
            }
        }
    }

    /// Draws pixels of the row at hand, eight at a time: those after the run are written over and put back.
    #[inline(always)]
    fn write(&self, row: usize, [low, high]: [usize; 2], canvas: &mut Canvas) {
        let first = row * canvas.size[0];
        let beyond = (first + high) * 3;
        let Some(saved) = canvas.rest.as_flattened()[beyond..].first_chunk::<BEYOND>().copied() else {
            self.singles(row, [low, high], canvas);
            return;
        };
        let pixels = &mut canvas.rest.as_flattened_mut()[3 * first..];
        let (tile, shift, part) = (self.tile, self.tile.trailing_zeros(), 1.0 / self.tile as f32);
        let mut nodes = &self.line[3 * ((low >> shift) - self.first[0])..];
        let mut column = low;
        let mut begin = low >> shift << shift;
        while let Some((own, _)) = nodes.split_first_chunk::<7>().filter(|_| column < high) {
            let [from, slope] = between(own, part);
            let end = high.min(begin + tile);
            while column < end {
                if let Some(group) = pixels[3 * column..].first_chunk_mut::<25>() {
                    eight(from, slope, (column - begin) % MOST_TILE, group);
                }
                column += 8;
            }
            (column, begin, nodes) = (end, begin + tile, &nodes[3..]);
        }
        pixels[3 * high..][..BEYOND].copy_from_slice(&saved);
    }

    /// The same one by one.
    fn singles(&self, row: usize, [low, high]: [usize; 2], canvas: &mut Canvas) {
        let pixels = &mut canvas.rest[row * canvas.size[0]..];
        for (column, place) in (low..high).zip(&mut pixels[low..high]) {
            let node = column / self.tile;
            let own = self.line[3 * (node - self.first[0])..].first_chunk::<7>();
            let [from, slope] = between(&own.copied().unwrap_or_default(), 1.0 / self.tile as f32);
            let step = (column - node * self.tile) as f32;
            for a in 0..3 {
                place[a] = from[a] + slope[a] * step;
            }
        }
    }
}

/// The place at a node and the step from pixel to pixel after it, with a fourth number of no meaning, from the numbers of two nodes and one more.
#[inline(always)]
fn between(nodes: &[f32; 7], part: f32) -> [[f32; 4]; 2] {
    let from = [nodes[0], nodes[1], nodes[2], nodes[3]];
    let mut slope = [nodes[3], nodes[4], nodes[5], nodes[6]];
    for k in 0..4 {
        slope[k] = (slope[k] - from[k]) * part;
    }
    [from, slope]
}

/// Numbers after a run that may be written over.
const BEYOND: usize = 24;

/// The places of eight pixels from the one after `step` steps on. Four numbers at a time, the fourth of which is written over by the next.
#[inline(always)]
fn eight(from: [f32; 4], slope: [f32; 4], step: usize, group: &mut [f32; 25]) {
    for (k, steps) in STEPS[step..step + 8].iter().enumerate() {
        for a in 0..4 {
            group[3 * k + a] = from[a] + slope[a] * steps[a];
        }
    }
}

/// Pixels from node to node, at most.
pub(super) const MOST_TILE: usize = 16;

/// Numbers of steps, four times each.
const STEPS: [[f32; 4]; MOST_TILE + 8] = {
    let mut steps = [[0.0; 4]; MOST_TILE + 8];
    let mut k = 0;
    while k < steps.len() {
        steps[k] = [k as f32; 4];
        k += 1;
    }
    steps
};
