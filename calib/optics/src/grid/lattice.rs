//! From candidates to a lattice: neighbours in each disc's own measure, then growth from a seed.

pub(super) mod assignment;
pub(super) mod index_lattice;
pub(super) mod rejected;
pub(super) mod sized;

use std::collections::{HashMap, VecDeque};

use nalgebra::{Matrix2, Vector2};

use crate::grid::candidates::blob::Blob;
use crate::grid::candidates::neighbours::{ALIKE, Nearest, Order, alike};

/// How far two opposite neighbours may be from opposite, beside their distance.
const MAX_SKEW: f64 = 0.3;
/// How far a disc may lie from where it is expected, beside a step of the lattice.
const NEAR_STEPS: f64 = 0.3;
/// Marks are larger than their neighbours by at most this factor in area.
const MAX_MARK_AREA: f64 = 20.0;
const MAX_SEEDS: usize = 24;

/// Whole coordinates of a disc.
pub(crate) type Cell = [i32; 2];

/// Candidates with their coordinates, in an arbitrary basis.
#[derive(Debug, Clone, Default)]
pub(crate) struct Lattice {
    pub(crate) cells: HashMap<Cell, usize>,
}

/// Two steps of the lattice at a disc, and how well their neighbours oppose each other.
#[derive(Debug, Clone, Copy)]
struct Basis {
    steps: [Vector2<f64>; 2],
    error: f64,
}

/// The largest lattice that grows from the best seeds; `enough` ends the search.
pub(crate) fn largest(blobs: &[Blob], enough: usize) -> Lattice {
    // Distances are measured in each disc's own shape, which takes perspective out of them.
    // A pixel's own second moment is in every shape: none is singular.
    let measures: Vec<Matrix2<f64>> = blobs
        .iter()
        .map(|b| b.shape.try_inverse().unwrap_or_default())
        .collect();
    let order = Order::new(blobs);
    let basis_of = |i: usize| basis(blobs, &order, &measures[i], i);
    let bases: Vec<Option<Basis>> = (0..blobs.len()).map(basis_of).collect();
    let mut seeds: Vec<usize> = (0..blobs.len()).filter(|i| bases[*i].is_some()).collect();
    let error = |i: &usize| bases[*i].map_or(f64::MAX, |b| b.error);
    // Seeds whose neighbours lie most evenly first: one of them is in the grid in nearly every image.
    seeds.sort_by(|i, j| error(i).total_cmp(&error(j)));
    let (mut best, mut used) = (Lattice::default(), vec![false; blobs.len()]);
    let mut tried = 0;
    for seed in seeds {
        if used[seed] || tried == MAX_SEEDS {
            continue;
        }
        tried += 1;
        let Some(basis) = bases[seed] else { continue };
        let lattice = grown(blobs, &order, seed, basis.steps);
        // A disc of a lattice that was grown would grow the same one again.
        lattice.cells.values().for_each(|i| used[*i] = true);
        if lattice.cells.len() > best.cells.len() {
            best = lattice;
        }
        if best.cells.len() >= enough {
            break;
        }
    }
    best
}

/// The two shortest steps to pairs of opposite neighbours, in the measure that makes the disc a circle.
fn basis(blobs: &[Blob], order: &Order, measure: &Matrix2<f64>, i: usize) -> Option<Basis> {
    let square = |d: &Vector2<f64>| (d.transpose() * measure * d)[0];
    let near = Nearest::of(blobs, order, measure, i);
    let mut steps: Vec<(f64, f64, Vector2<f64>)> = Vec::new();
    for (j, a) in near.iter().enumerate() {
        for b in &near[j + 1..] {
            let (error, mean) = (square(&(a.1 + b.1)), 0.5 * (a.0 + b.0));
            if error < (MAX_SKEW * mean).powi(2) {
                steps.push((mean, error.sqrt() / mean, (a.1 - b.1) * 0.5));
            }
        }
    }
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = steps.first()?;
    // The determinant of the measure turns an area of the image into one of the circle's plane.
    let scale = measure.determinant().max(0.0).sqrt();
    // Less than 20 degrees apart (a sine of 0.35) is the same direction, or twice the first step.
    let across = |s: &&(f64, f64, Vector2<f64>)| (first.2.perp(&s.2) * scale).abs() > 0.35 * first.0 * s.0;
    let second = steps.iter().find(across)?;
    Some(Basis {
        steps: [first.2, second.2],
        error: first.1 + second.1,
    })
}

fn grown(blobs: &[Blob], order: &Order, seed: usize, steps: [Vector2<f64>; 2]) -> Lattice {
    let mut growth = Growth {
        blobs,
        order,
        cells: HashMap::from([([0, 0], seed)]),
        steps: HashMap::from([([0, 0], steps)]),
        used: vec![false; blobs.len()],
    };
    growth.used[seed] = true;
    let mut queue = VecDeque::from([[0, 0]]);
    // In rings about the seed: most discs have neighbours behind them and beside them to take their steps from.
    while let Some(cell) = queue.pop_front() {
        growth.settle(cell);
        for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
            queue.extend(growth.towards(cell, axis, sign));
        }
    }
    Lattice { cells: growth.cells }
}

struct Growth<'a> {
    blobs: &'a [Blob],
    order: &'a Order,
    cells: HashMap<Cell, usize>,
    steps: HashMap<Cell, [Vector2<f64>; 2]>,
    used: Vec<bool>,
}

fn moved(cell: Cell, axis: usize, by: i32) -> Cell {
    let mut cell = cell;
    cell[axis] += by;
    cell
}

impl Growth<'_> {
    fn at(&self, cell: Cell) -> Option<Vector2<f64>> {
        self.cells.get(&cell).map(|i| self.blobs[*i].at)
    }

    /// Replaces the inherited steps of a disc by those to its neighbours.
    fn settle(&mut self, cell: Cell) {
        let Some(here) = self.at(cell) else { return };
        let mut steps = self.steps.get(&cell).copied().unwrap_or_default();
        for (axis, step) in steps.iter_mut().enumerate() {
            match (self.at(moved(cell, axis, 1)), self.at(moved(cell, axis, -1))) {
                (Some(a), Some(b)) => *step = (a - b) * 0.5,
                (Some(a), None) => *step = a - here,
                (None, Some(b)) => *step = here - b,
                (None, None) => {}
            }
        }
        self.steps.insert(cell, steps);
    }

    /// Looks for the next disc along an axis, and gives it its coordinates.
    fn towards(&mut self, cell: Cell, axis: usize, sign: i32) -> Option<Cell> {
        let next = moved(cell, axis, sign);
        // A grid has at most 200 columns and rows: what lies farther from a seed is of no grid.
        if self.cells.contains_key(&next) || next.iter().any(|c| c.abs() > 500) {
            return None;
        }
        let from = *self.cells.get(&cell)?;
        let steps = *self.steps.get(&cell)?;
        let expected = self.blobs[from].at + steps[axis] * f64::from(sign);
        let inverse = Matrix2::from_columns(&steps).try_inverse()?;
        let mut best: Option<(f64, usize)> = None;
        // The ellipse of all ways shorter than NEAR_STEPS steps, along x and along y.
        let reach = [0, 1].map(|k| NEAR_STEPS * steps[0][k].hypot(steps[1][k]));
        let area = self.blobs[from].area;
        for spot in self.order.about(expected, reach) {
            if self.used[spot.index] || !alike(spot.area, area, MAX_MARK_AREA) {
                continue;
            }
            let off = (inverse * (spot.at - expected)).norm();
            // Of two that lie there the one of the right size.
            let unlike = if alike(spot.area, area, ALIKE) { 0.0 } else { 0.1 };
            if off < NEAR_STEPS && best.is_none_or(|b| off + unlike < b.0) {
                best = Some((off + unlike, spot.index));
            }
        }
        let (_, found) = best?;
        self.used[found] = true;
        self.cells.insert(next, found);
        self.steps.insert(next, steps);
        Some(next)
    }
}
