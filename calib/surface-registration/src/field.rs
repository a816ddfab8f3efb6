//! The signed distance to a surface on a lattice: fast enough for thousands of starts.
//!
//! Two levels: a coarse lattice everywhere, and bricks of a fine one wherever the surface is near; both are interpolated linearly in each
//! axis. The search goes by this field. What is reported at the end does not: the last steps use [`crate::Surface::distance`], so that
//! the field's error is in no result.

mod build;
mod rows;

use geometry::{Frame, Point};
use nalgebra::Vector3;

use crate::Surface;

/// Cells along a brick's edge.
const BRICK: usize = 8;
/// Nodes along a brick's edge.
const BRICK_NODES: usize = BRICK + 1;
/// The most nodes of the coarse lattice, or of all bricks: 400 MB each.
pub const MOST_NODES: usize = 100_000_000;
/// Of a place where there is no brick.
const NO_BRICK: u32 = u32::MAX;

/// How fine a field is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacing {
    /// Spacing of the fine lattice, mm.
    pub fine_mm: f64,
    /// Spacing of the coarse lattice in fine ones: 1, 2, 4 or 8.
    pub coarse: usize,
    /// Fine where the surface is nearer than this, mm.
    pub band_mm: f64,
    /// How far around the surface's box the coarse lattice goes, mm.
    pub margin_mm: f64,
    /// Threads that make it; the field is the same whatever their number.
    pub threads: usize,
}

impl Default for Spacing {
    fn default() -> Self {
        Self {
            fine_mm: 2.0,
            coarse: 2,
            band_mm: 8.0,
            margin_mm: 40.0,
            threads: 2,
        }
    }
}

/// Why a field was not made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// A length is not a number above 0, or the ratio or the number of threads is none of those that are allowed.
    #[error("{what} is {found}; allowed is {allowed}")]
    Spacing {
        /// What it is of.
        what: &'static str,
        /// What was found.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// More nodes than fit.
    #[error("a field of {nodes} nodes; at most {MOST_NODES} are made: a wider spacing is needed")]
    TooFine {
        /// How many it would have.
        nodes: usize,
    },
}

/// The signed distance on a lattice.
#[derive(Debug, Clone)]
pub struct Field {
    spacing: Spacing,
    origin: Vector3<f64>,
    /// Fine cells along each axis: multiples of [`BRICK`].
    cells: [usize; 3],
    /// Nodes of the coarse lattice along each axis.
    nodes: [usize; 3],
    coarse: Vec<f32>,
    /// For each brick's place, its number.
    table: Vec<u32>,
    bricks: Vec<f32>,
}

impl Field {
    /// The field of a surface.
    ///
    /// # Errors
    /// Each variant of [`FieldError`].
    pub fn new<F: Frame>(surface: &Surface<F>, spacing: Spacing) -> Result<Self, FieldError> {
        build::build(&surface.tree, &surface.caps, surface.facts().is_sheet, spacing)
    }

    /// How fine it is.
    pub fn spacing(&self) -> Spacing {
        self.spacing
    }

    /// Nodes that were made: of the coarse lattice, and of bricks.
    pub fn made_nodes(&self) -> [usize; 2] {
        [self.coarse.len(), self.bricks.len()]
    }

    /// Signed distance and its gradient at a place of the surface's frame, mm.
    pub fn at<F: Frame>(&self, place: Point<F>) -> (f64, [f64; 3]) {
        let (d, g) = self.look(&Vector3::from(place.mm()));
        (d, g.into())
    }

    /// Signed distance and gradient. Beyond the lattice: that at its border, and the way there.
    #[inline]
    pub(crate) fn look(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let per_mm = 1.0 / self.spacing.fine_mm;
        let u = (p - self.origin) * per_mm;
        let inside = (0..3).all(|k| u[k] >= 0.0 && u[k] < self.cells[k] as f64);
        if inside {
            return self.within(&u);
        }
        self.beyond(&u)
    }

    #[cold]
    fn beyond(&self, u: &Vector3<f64>) -> (f64, Vector3<f64>) {
        // The last cell ends just below the number of cells; NaN goes to the first.
        let held = Vector3::from_fn(|k, _| u[k].max(0.0).min(self.cells[k] as f64 - 1e-9));
        let (d, g) = self.within(&held);
        let way = (u - held) * self.spacing.fine_mm;
        let length = way.norm();
        if length.is_nan() {
            return (f64::NAN, Vector3::repeat(f64::NAN));
        }
        (d + length, way.try_normalize(1e-6).unwrap_or(g))
    }

    #[inline]
    fn within(&self, u: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let cell = [u.x as usize, u.y as usize, u.z as usize];
        let brick = cell.map(|c| c / BRICK);
        let places = self.cells.map(|n| n / BRICK);
        let number = self.table[(brick[2] * places[1] + brick[1]) * places[0] + brick[0]];
        if number == NO_BRICK {
            let wide = self.spacing.coarse;
            let cell = cell.map(|c| c / wide);
            let f = Vector3::from_fn(|k, _| u[k] / wide as f64 - cell[k] as f64);
            let row = self.nodes[0];
            let layer = row * self.nodes[1];
            let first = (cell[2] * self.nodes[1] + cell[1]) * row + cell[0];
            let length = self.spacing.fine_mm * wide as f64;
            return linear(&self.coarse[first..=first + layer + row + 1], row, layer, &f, length);
        }
        let local = cell.map(|c| c % BRICK);
        let f = Vector3::from_fn(|k, _| u[k] - cell[k] as f64);
        const ROW: usize = BRICK_NODES;
        const LAYER: usize = BRICK_NODES * BRICK_NODES;
        let first = number as usize * LAYER * BRICK_NODES + (local[2] * ROW + local[1]) * ROW + local[0];
        linear(
            &self.bricks[first..=first + LAYER + ROW + 1],
            ROW,
            LAYER,
            &f,
            self.spacing.fine_mm,
        )
    }
}

/// Linear in each axis between eight nodes; `f` is the place in the cell, 0 to 1, and `length` the cell's edge.
#[inline]
fn linear(v: &[f32], row: usize, layer: usize, f: &Vector3<f64>, length: f64) -> (f64, Vector3<f64>) {
    let at = |i: usize| f64::from(v[i]);
    let x0 = [at(0), at(row), at(layer), at(layer + row)];
    let x1 = [at(1), at(row + 1), at(layer + 1), at(layer + row + 1)];
    // First along x: four values and four slopes.
    let dx = [x1[0] - x0[0], x1[1] - x0[1], x1[2] - x0[2], x1[3] - x0[3]];
    let vx = [x0[0] + f.x * dx[0], x0[1] + f.x * dx[1], x0[2] + f.x * dx[2], x0[3] + f.x * dx[3]];
    let (dy0, dy1) = (vx[1] - vx[0], vx[3] - vx[2]);
    let (vy0, vy1) = (vx[0] + f.y * dy0, vx[2] + f.y * dy1);
    let (sx0, sx1) = (dx[0] + f.y * (dx[1] - dx[0]), dx[2] + f.y * (dx[3] - dx[2]));
    let slope = Vector3::new(sx0 + f.z * (sx1 - sx0), dy0 + f.z * (dy1 - dy0), vy1 - vy0);
    (vy0 + f.z * (vy1 - vy0), slope / length)
}
