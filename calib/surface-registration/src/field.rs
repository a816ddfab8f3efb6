//! The signed distance to a surface on a lattice: fast enough for thousands of starts.
//!
//! One level, interpolated linearly in each axis. The search goes by this field; what is reported at the end does not: the last steps
//! use the surface itself ([`crate::Surface::distance`]), so that the field's error is in no result. That is instead of a fine lattice
//! with a smooth interpolant near the bone, which would cost ten times the memory and still be wrong by some hundredths of a millimetre.

mod build;
mod rows;

use geometry::{Frame, Point};
use nalgebra::Vector3;

use crate::Surface;

/// The most nodes: 1.5 GB while it is made, 0.3 GB after.
pub const MOST_NODES: usize = 60_000_000;

/// How fine a field is, and how far it goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacing {
    /// Spacing of the lattice, mm.
    pub spacing_mm: f64,
    /// How far around the surface's box it goes, mm. Beyond, a distance is that at its border and the way there.
    pub margin_mm: f64,
}

impl Default for Spacing {
    fn default() -> Self {
        Self {
            spacing_mm: 2.0,
            margin_mm: 40.0,
        }
    }
}

/// Why a field was not made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// A length is out of its range.
    #[error("{what} is {found} mm; allowed is {allowed}")]
    Spacing {
        /// What it is of.
        what: &'static str,
        /// What was found, mm.
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
    nodes: [usize; 3],
    values: Vec<f32>,
    /// Whether the place of the surface that is nearest to a node is on an open border; empty where it has none.
    open: Vec<bool>,
    rough: Rough,
}

/// The field at every second node in four bytes: of a pelvis as much as a processor keeps near itself.
#[derive(Debug, Clone)]
struct Rough {
    per_mm: f32,
    spacing_mm: f32,
    nodes: [usize; 3],
    /// Distance in steps of [`ROUGH_MM`], [`ROUGH_BEYOND`] beyond an open border; gradient in steps of one over [`ROUGH_SLOPE`].
    values: Vec<[i8; 4]>,
}

/// Distances up to 63 mm, to a quarter of a millimetre: what is further costs the same.
const ROUGH_MM: f32 = 0.5;
const ROUGH_SLOPE: f32 = 127.0;
const ROUGH_BEYOND: i8 = i8::MIN;

impl Rough {
    fn new(spacing_mm: f64, size: [usize; 3], values: &[f32], open: &[bool]) -> Self {
        let nodes = size.map(|n| n.div_ceil(2));
        let wide = 2.0 * spacing_mm;
        let steps = [1, size[0], size[0] * size[1]];
        let mut packed = Vec::with_capacity(nodes.iter().product());
        for k in 0..nodes[2] {
            for j in 0..nodes[1] {
                for i in 0..nodes[0] {
                    let at = [2 * i, 2 * j, 2 * k];
                    let place = at[2] * steps[2] + at[1] * steps[1] + at[0];
                    let slope = [0, 1, 2].map(|axis| {
                        // One-sided at the lattice's faces.
                        let ahead = usize::from(at[axis] + 1 < size[axis]);
                        let back = usize::from(at[axis] > 0);
                        let rise = values[place + ahead * steps[axis]] - values[place - back * steps[axis]];
                        let run = (ahead + back).max(1) as f32 * spacing_mm as f32;
                        // Casts saturate.
                        (rise / run * ROUGH_SLOPE).round() as i8
                    });
                    let steps = ((values[place] / ROUGH_MM).round() as i8).max(-i8::MAX);
                    let is_beyond = open.get(place).copied().unwrap_or(false);
                    let steps = if is_beyond { ROUGH_BEYOND } else { steps };
                    packed.push([steps, slope[0], slope[1], slope[2]]);
                }
            }
        }
        Self {
            per_mm: (1.0 / wide) as f32,
            spacing_mm: wide as f32,
            nodes,
            values: packed,
        }
    }
}

impl Field {
    /// What [`Field::glance`] gives for the distance where the bone nearest is an open border.
    pub(crate) const BEYOND: f32 = f32::NEG_INFINITY;

    /// The field of a surface: exact at nodes within 1.5 spacings of it, and beyond the distance to the nearest of the places that were
    /// found there, which is too long by less than a tenth of the spacing.
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

    /// Nodes of the lattice.
    pub fn nodes(&self) -> usize {
        self.values.len()
    }

    /// Signed distance and its gradient at a place of the surface's frame, mm.
    pub fn at<F: Frame>(&self, place: Point<F>) -> (f64, [f64; 3]) {
        let (d, g) = self.look(&Vector3::from(place.mm()));
        (d, g.into())
    }

    #[inline]
    pub(crate) fn look(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let per_mm = 1.0 / self.spacing.spacing_mm;
        let u = (p - self.origin) * per_mm;
        let inside = (0..3).all(|k| u[k] >= 0.0 && u[k] < (self.nodes[k] - 1) as f64);
        if inside {
            return self.within(&u);
        }
        self.beyond(&u)
    }

    /// Whether no node is nearest to an open border.
    pub(crate) fn is_closed(&self) -> bool {
        self.open.is_empty()
    }

    /// Whether nothing is known of the bone beyond the place of it that is nearest to `p`: by the nearest node.
    #[inline]
    pub(crate) fn is_beyond(&self, p: &Vector3<f64>) -> bool {
        if self.open.is_empty() {
            return false;
        }
        // A NaN becomes 0.
        let u = (p - self.origin) / self.spacing.spacing_mm;
        let [i, j, k] = [0, 1, 2].map(|axis| (u[axis].round().max(0.0) as usize).min(self.nodes[axis] - 1));
        self.open[(k * self.nodes[1] + j) * self.nodes[0] + i]
    }

    /// A place from the lattice's origin, as [`Field::glance`] takes it.
    pub(crate) fn in_lattice(&self, p: &Vector3<f64>) -> [f32; 3] {
        let p = p - self.origin;
        [p.x as f32, p.y as f32, p.z as f32]
    }

    /// Roughly the distance at a place, from the lattice's origin, and its gradient: linear from the nearest node of every second one.
    /// For what is compared by millimetres. Infinite beyond the lattice, [`Field::BEYOND`] beyond an open
    /// border.
    #[inline]
    pub(crate) fn glance(&self, p: [f32; 3]) -> (f32, [f32; 3]) {
        let Rough {
            per_mm,
            spacing_mm,
            nodes,
            values,
        } = &self.rough;
        // Half a step on, so that the cast, which cuts off, gives the nearest node.
        let u = p.map(|x| x * per_mm + 0.5);
        // A NaN is in no range.
        if !(0..3).all(|k| u[k] >= 0.0 && u[k] < nodes[k] as f32) {
            return (f32::INFINITY, [0.0; 3]);
        }
        let i = u.map(|x| x as usize);
        let [d, x, y, z] = values[(i[2] * nodes[1] + i[1]) * nodes[0] + i[0]];
        if d == ROUGH_BEYOND {
            return (Self::BEYOND, [0.0; 3]);
        }
        let slope = [x, y, z].map(|g| f32::from(g) / ROUGH_SLOPE);
        let off = [0, 1, 2].map(|k| p[k] - i[k] as f32 * spacing_mm);
        let on = slope[0] * off[0] + slope[1] * off[1] + slope[2] * off[2];
        (f32::from(d) * ROUGH_MM + on, slope)
    }

    #[cold]
    fn beyond(&self, u: &Vector3<f64>) -> (f64, Vector3<f64>) {
        // The last cell ends just below the last node; NaN goes to the first.
        let held = Vector3::from_fn(|k, _| u[k].max(0.0).min((self.nodes[k] - 1) as f64 - 1e-6));
        let (d, g) = self.within(&held);
        let way = (u - held) * self.spacing.spacing_mm;
        let length = way.norm();
        if length.is_nan() {
            return (f64::NAN, Vector3::repeat(f64::NAN));
        }
        (d + length, way.try_normalize(1e-6).unwrap_or(g))
    }

    /// Linear in each axis between the eight nodes around `u`, in nodes.
    #[inline]
    fn within(&self, u: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let cell = [u.x as usize, u.y as usize, u.z as usize];
        let f = Vector3::new(u.x - cell[0] as f64, u.y - cell[1] as f64, u.z - cell[2] as f64);
        let row = self.nodes[0];
        let layer = row * self.nodes[1];
        let first = cell[2] * layer + cell[1] * row + cell[0];
        // One check of the bounds for all eight.
        let v = &self.values[first..=first + layer + row + 1];
        let at = |i: usize| f64::from(v[i]);
        let x0 = [at(0), at(row), at(layer), at(layer + row)];
        let x1 = [at(1), at(row + 1), at(layer + 1), at(layer + row + 1)];
        let dx = [x1[0] - x0[0], x1[1] - x0[1], x1[2] - x0[2], x1[3] - x0[3]];
        let vx = [
            x0[0] + f.x * dx[0],
            x0[1] + f.x * dx[1],
            x0[2] + f.x * dx[2],
            x0[3] + f.x * dx[3],
        ];
        let (dy0, dy1) = (vx[1] - vx[0], vx[3] - vx[2]);
        let (vy0, vy1) = (vx[0] + f.y * dy0, vx[2] + f.y * dy1);
        let (sx0, sx1) = (dx[0] + f.y * (dx[1] - dx[0]), dx[2] + f.y * (dx[3] - dx[2]));
        let slope = Vector3::new(sx0 + f.z * (sx1 - sx0), dy0 + f.z * (dy1 - dy0), vy1 - vy0);
        (vy0 + f.z * (vy1 - vy0), slope / self.spacing.spacing_mm)
    }
}
