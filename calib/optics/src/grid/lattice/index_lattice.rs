//! Which column and row a disc of the lattice is.

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector2};

use crate::grid::candidates::blob::Blob;
use crate::grid::fit::disc_jacobian::point;
use crate::grid::found::GridSpec;
use crate::grid::homography::{homography, jacobian, project};
use crate::grid::lattice::{Cell, Lattice};

/// A line of the grid counts as seen with this share of its discs.
pub(crate) const LINE: f64 = 0.35;

/// The fewest discs that make a homography.
const MIN_DISCS: usize = 8;

/// Discs with coordinates whose first axis goes to the right, or up to a quarter turn from it.
#[derive(Debug, Clone)]
pub(crate) struct IndexedLattice {
    pub(crate) cells: HashMap<Cell, usize>,
    pub(crate) h: Matrix3<f64>,
    /// First and last column and row that are seen.
    pub(crate) span: [[i32; 2]; 2],
}

/// The bases a lattice of squares can have been grown in: itself and its shears.
const BASES: [[i32; 4]; 9] = [
    [1, 0, 0, 1],
    [1, 1, 0, 1],
    [1, -1, 0, 1],
    [1, 0, 1, 1],
    [1, 0, -1, 1],
    [1, 2, 0, 1],
    [1, -2, 0, 1],
    [1, 0, 2, 1],
    [1, 0, -2, 1],
];

/// A homography of all but what lies off it by more than 0.3 steps, and what was left. What the border cuts has a say only
/// where there is hardly anything else.
pub(crate) fn agreed(blobs: &[Blob], cells: &HashMap<Cell, usize>) -> Option<(Matrix3<f64>, HashMap<Cell, usize>)> {
    let mut kept: Vec<(Cell, usize)> = cells.iter().map(|(c, i)| (*c, *i)).collect();
    // A hash map's order changes from run to run, and with it the rounding of the homography.
    kept.sort_unstable();
    let fit = |kept: &[(Cell, usize)]| {
        let pair = |(c, i): &(Cell, usize)| (point(*c), blobs[*i].at);
        let seen: Vec<_> = kept.iter().filter(|k| !blobs[k.1].cut).map(pair).collect();
        let enough = seen.len() >= MIN_DISCS;
        let of_seen = enough.then(|| homography(&seen)).flatten();
        of_seen.or_else(|| homography(&kept.iter().map(pair).collect::<Vec<_>>()))
    };
    // Outliers are left out against a fit that they bend: the next one is better, and more may have to go.
    let mut h = fit(&kept)?;
    for _ in 0..4 {
        let inverse = h.try_inverse()?;
        let count = kept.len();
        kept.retain(|(c, i)| (project(&inverse, blobs[*i].at) - point(*c)).norm() < 0.3);
        if kept.len() == count {
            break;
        }
        h = fit(&kept)?;
    }
    (kept.len() >= MIN_DISCS).then(|| (h, kept.into_iter().collect()))
}

/// How far from round the discs are under a homography: the mean of `trace / (2 sqrt det)` less 1.
fn unroundness(blobs: &[Blob], cells: &HashMap<Cell, usize>, h: &Matrix3<f64>) -> f64 {
    let one = |(cell, i): (&Cell, &usize)| {
        let back = jacobian(h, point(*cell)).try_inverse().unwrap_or_default();
        let shape = back * blobs[*i].shape * back.transpose();
        // The arithmetic over the geometric mean of the eigenvalues: 1 for a circle alone, whatever its size.
        (shape.trace() / (2.0 * shape.determinant().max(1e-300).sqrt())).min(1e3) - 1.0
    };
    // Summed in the order of size: a map has another order in every run, and rounding would decide near ties.
    let mut all: Vec<f64> = cells.iter().map(one).collect();
    all.sort_by(f64::total_cmp);
    all.iter().sum::<f64>() / cells.len().max(1) as f64
}

/// The most cells in a window of a size, and its first column and row.
fn best_window(cells: &HashMap<Cell, usize>, size: [i32; 2]) -> (usize, Cell) {
    let bounds = |k: usize| {
        let all = cells.keys().map(|c| c[k]);
        (all.clone().min().unwrap_or(0), all.max().unwrap_or(0))
    };
    let ((x0, x1), (y0, y1)) = (bounds(0), bounds(1));
    let (nx, ny) = ((x1 - x0 + 1) as usize, (y1 - y0 + 1) as usize);
    // Sums over rectangles from the corner: each window then costs four of them.
    let mut sums = vec![vec![0_usize; nx + 1]; ny + 1];
    for y in 0..ny {
        for x in 0..nx {
            let here = usize::from(cells.contains_key(&[x0 + x as i32, y0 + y as i32]));
            sums[y + 1][x + 1] = here + sums[y][x + 1] + sums[y + 1][x] - sums[y][x];
        }
    }
    let mut best = (0, [x0, y0]);
    for y in 0..ny {
        for x in 0..nx {
            let (xe, ye) = ((x + size[0] as usize).min(nx), (y + size[1] as usize).min(ny));
            let count = sums[ye][xe] + sums[y][x] - sums[y][xe] - sums[ye][x];
            if count > best.0 {
                best = (count, [x0 + x as i32, y0 + y as i32]);
            }
        }
    }
    best
}

/// Gives the lattice the basis in which most of it lies in a rectangle of the grid's size and its discs are round.
pub(crate) fn place(blobs: &[Blob], lattice: &Lattice, spec: &GridSpec) -> Option<IndexedLattice> {
    let size = [spec.cols as i32, spec.rows as i32];
    // A shear changes no homography, only coordinates: what is far off it goes before bases are compared.
    let (_, kept) = agreed(blobs, &lattice.cells)?;
    let mut best: Option<(f64, HashMap<Cell, usize>)> = None;
    for [a, b, c, d] in BASES {
        let turned: HashMap<Cell, usize> = kept
            .iter()
            .map(|([u, v], i)| ([a * u + b * v, c * u + d * v], *i))
            .collect();
        let Some((h, _)) = agreed(blobs, &turned) else { continue };
        // The basis may be found a quarter turn off, which is decided later.
        let upright = best_window(&turned, size).0;
        let lying = best_window(&turned, [size[1], size[0]]).0;
        let held = upright.max(lying) as f64 / kept.len() as f64;
        let score = held - 0.15 * unroundness(blobs, &turned, &h).min(4.0);
        if best.as_ref().is_none_or(|b| score > b.0) {
            best = Some((score, turned));
        }
    }
    let cells = oriented(blobs, best?.1, size)?;
    windowed(blobs, cells, spec.marks.is_empty().then_some(size))
}

/// Turns the axes: the first to the right in the image, the second a quarter turn clockwise from it; by a quarter turn
/// more where only that fits the size.
fn oriented(blobs: &[Blob], cells: HashMap<Cell, usize>, size: [i32; 2]) -> Option<HashMap<Cell, usize>> {
    let (h, _) = agreed(blobs, &cells)?;
    let n = cells.len() as f64;
    // Perspective turns the axes over the grid: their direction is taken in the middle.
    let middle = cells.keys().map(|c| point(*c)).sum::<Vector2<f64>>() / n;
    let j = jacobian(&h, middle);
    // A lattice may have been grown with its axes exchanged; a grid is never seen from behind.
    let mirrored = j.determinant() < 0.0;
    let turns: [[i32; 4]; 4] = [[1, 0, 0, 1], [0, 1, -1, 0], [-1, 0, 0, -1], [0, -1, 1, 0]];
    let mut best: Option<(f64, HashMap<Cell, usize>)> = None;
    for [a, b, c, d] in turns {
        let turn = |[u, v]: Cell| {
            let [u, v] = if mirrored { [v, u] } else { [u, v] };
            [a * u + b * v, c * u + d * v]
        };
        let turned: HashMap<Cell, usize> = cells.iter().map(|(cell, i)| (turn(*cell), *i)).collect();
        let Some((h, _)) = agreed(blobs, &turned) else { continue };
        let middle = turned.keys().map(|c| point(*c)).sum::<Vector2<f64>>() / n;
        let right = jacobian(&h, middle)
            .column(0)
            .into_owned()
            .try_normalize(0.0)
            .unwrap_or_default();
        let held = best_window(&turned, size).0 as f64 / n;
        // Rounded to fiftieths, so that a few discs more decide nothing; a fifth of the discs outweighs any direction.
        let score = 10.0 * (held * 50.0).round() / 50.0 + right.x;
        if best.as_ref().is_none_or(|b| score > b.0) {
            best = Some((score, turned));
        }
    }
    best.map(|b| b.1)
}

/// First and last line along an axis that hold a share of what such a line has.
fn span(cells: &HashMap<Cell, usize>, axis: usize, across: Option<i32>) -> [i32; 2] {
    let mut counts: HashMap<i32, i32> = HashMap::new();
    cells.keys().for_each(|c| *counts.entry(c[axis]).or_default() += 1);
    // Of a part of the grid, lines have what the fullest has.
    let across = across.unwrap_or_else(|| counts.values().copied().max().unwrap_or(0));
    let needed = (LINE * f64::from(across)).ceil() as i32;
    let seen = counts.iter().filter(|(_, n)| **n >= needed).map(|(k, _)| *k);
    let (first, last) = (seen.clone().min().unwrap_or(0), seen.max().unwrap_or(-1));
    [first, last]
}

/// Leaves out what lies beyond the lines that count: by the grid's `size` where all of it is to be seen.
fn windowed(blobs: &[Blob], cells: HashMap<Cell, usize>, size: Option<[i32; 2]>) -> Option<IndexedLattice> {
    let spans = [0, 1].map(|k| span(&cells, k, size.map(|s| s[1 - k])));
    let inside = |c: &Cell| (0..2).all(|k| (spans[k][0]..=spans[k][1]).contains(&c[k]));
    let cells: HashMap<Cell, usize> = cells.into_iter().filter(|(c, _)| inside(c)).collect();
    let (h, cells) = agreed(blobs, &cells)?;
    Some(IndexedLattice { cells, h, span: spans })
}
