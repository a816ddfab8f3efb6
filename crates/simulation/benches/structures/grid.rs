//! A grid of cells as large as boxes are, kept as a sorted list.

use nalgebra::Vector2;

use super::{Arc, Bounds, Found, near};

/// Cells along a box at most.
const MOST_CELLS: f64 = 8.0;

/// Cells of a side, and where they begin.
struct Grid {
    origin: Vector2<f64>,
    cell: f64,
    /// Half the distance, and rounding.
    about: Vector2<f64>,
}

impl Grid {
    /// As large as boxes are on average with the distance about them, and no box over too many.
    fn new(boxes: &[Bounds], within: f64) -> Self {
        let (mut sum, mut most, mut far) = (0.0, 0.0_f64, 0.0_f64);
        let mut origin = Vector2::repeat(f64::INFINITY);
        for [low, high] in boxes {
            let side = (high - low).max();
            sum += side;
            most = most.max(side);
            far = far.max(low.amax()).max(high.amax());
            origin = origin.inf(low);
        }
        let about = Vector2::repeat(0.5 * within + 4.0 * f64::EPSILON * far);
        let cell = (sum / boxes.len().max(1) as f64 + within).max((most + within) / MOST_CELLS);
        Self {
            origin: origin - about,
            cell: cell.max(f64::EPSILON * far).max(f64::MIN_POSITIVE),
            about,
        }
    }

    fn cell(&self, at: Vector2<f64>) -> [u32; 2] {
        let place = (at - self.origin) / self.cell;
        // Conversions saturate: what is farther shares the last cell.
        [place.x as u32, place.y as u32]
    }
}

/// Every two boxes `[low corner, high corner]` that come as near as `within` along both axes, by their numbers, once each.
///
/// In the order of the grid's cells. `O(n log n)` where boxes are of like size and few lie over one another.
fn near_boxes(boxes: &[Bounds], within: f64) -> Vec<[u32; 2]> {
    let grid = Grid::new(boxes, within);
    let mut held: Vec<([u32; 2], u32)> = Vec::with_capacity(4 * boxes.len());
    for (number, [low, high]) in boxes.iter().enumerate() {
        let (from, to) = (grid.cell(low - grid.about), grid.cell(high + grid.about));
        let cells = (from[0]..=to[0]).flat_map(|x| (from[1]..=to[1]).map(move |y| [x, y]));
        held.extend(cells.map(|cell| (cell, number as u32)));
    }
    held.sort_unstable();
    let mut found = Vec::new();
    for run in held.chunk_by(|a, b| a.0 == b.0) {
        for (k, (cell, first)) in run.iter().enumerate() {
            let one = &boxes[*first as usize];
            for (_, second) in &run[k + 1..] {
                let two = &boxes[*second as usize];
                // Of the cells that hold both, the lowest one names them.
                if near(one, two, within) && grid.cell(one[0].sup(&two[0]) - grid.about) == *cell {
                    found.push([*first, *second]);
                }
            }
        }
    }
    found
}

pub(super) fn find(arcs: &[Arc], within: f64) -> Found {
    let boxes: Vec<Bounds> = arcs.iter().map(|arc| arc.bounds).collect();
    let mut found = Found::default();
    for [one, two] in near_boxes(&boxes, within) {
        found.look_at_both(arcs, one as usize, two as usize, within);
    }
    found
}
