//! What does not change while an organ moves: its cubes, and where it is at rest.

use super::border::{Beside, neighbours};
use super::error::NoShape;
use super::placed::{Held, Placed};
use super::quadratic::{self, weights};
use super::region::Region;

/// Cubes of an organ, and nodes, at most.
const MOST_CUBES: u64 = 1 << 18;
const MOST_NODES: u64 = 1 << 23;
/// Corners of pieces in the box about an organ, at most.
const MOST_CORNERS: u64 = 1 << 23;
/// A cube is divided into this many pieces along an axis, at most.
const MOST_PIECES: i32 = 64;
/// Pieces of all cubes, at most.
const MOST_IN_ALL: u64 = 1 << 26;
/// A place may be so far outside the nearest cube, in its sides, and goes with it.
const MOST_OUTSIDE: f64 = 0.5;
/// Distance of a corner of a cube from the lattice of pieces, in pieces.
const OFF_LATTICE: f64 = 1e-6;

/// A cube of 27 nodes along the axes of the CT.
#[derive(Debug, Clone)]
pub struct Cube {
    /// Its lowest corner at rest, mm in the CT's frame.
    pub low: [f64; 3],
    /// Its side, mm.
    pub side: f64,
    /// Its nodes, fastest along x, then y, then z. Those on a larger neighbour's face lie on that face's function.
    pub nodes: [u32; 27],
}

/// An organ at rest.
#[derive(Debug, Clone)]
pub struct Shape {
    pub(super) cubes: Vec<Placed>,
    pub(super) region: Region,
    pub(super) nodes: usize,
    /// The place of the lattice's first corner, the step, and the number of its corners along the axes.
    pub(super) origin: [f64; 3],
    pub(super) piece_mm: f64,
    pub(super) corners: [i32; 3],
    /// What lies beside each cube; none where that is not known.
    pub(super) beside: Option<Vec<Beside>>,
}

impl Shape {
    /// The organ of `cubes` over `nodes` nodes, to be cut in pieces of at most `piece_mm`; sides of cubes are powers of two times the
    /// smallest, and the corners lie on a lattice of the smallest side.
    ///
    /// # Errors
    /// Each variant of [`NoShape`].
    pub fn new(cubes: &[Cube], nodes: usize, region: Region, piece_mm: f64) -> Result<Self, NoShape> {
        count("cubes", cubes.len() as u64, MOST_CUBES)?;
        count("nodes", nodes as u64, MOST_NODES)?;
        for (k, cube) in cubes.iter().enumerate() {
            check(k, cube, nodes)?;
        }
        let least = cubes.iter().map(|c| c.side).fold(f64::INFINITY, f64::min);
        let most = cubes.iter().map(|c| c.side).fold(0.0, f64::max);
        let piece = piece(least, most, piece_mm).ok_or(NoShape::Piece(piece_mm))?;
        let origin = std::array::from_fn(|a| cubes.iter().map(|c| c.low[a]).fold(f64::INFINITY, f64::min));
        let mut shape = Self {
            cubes: Vec::with_capacity(cubes.len()),
            region,
            nodes,
            origin,
            piece_mm: piece,
            corners: [1; 3],
            beside: None,
        };
        for (k, cube) in cubes.iter().enumerate() {
            let placed = shape.place(cube).map_err(|why| NoShape::Cube { cube: k, why })?;
            shape.corners = std::array::from_fn(|a| shape.corners[a].max(placed.corner[a] + placed.span + 1));
            shape.cubes.push(placed);
        }
        let all = |product: u64, n: &i32| product.saturating_mul(u64::from(n.unsigned_abs()));
        count("corners of pieces", shape.corners.iter().fold(1, all), MOST_CORNERS)?;
        let pieces = shape.cubes.iter().map(|cube| all(1, &cube.span.pow(3)));
        count("pieces of all cubes", pieces.sum(), MOST_IN_ALL)?;
        for k in 0..shape.cubes.len() {
            let held = shape.all_held(&shape.cubes[k]);
            let cube = &mut shape.cubes[k];
            cube.uniform = held
                .first()
                .copied()
                .filter(|first| held.iter().all(|own| own == first));
            if cube.uniform.is_none() {
                cube.held = held;
            }
        }
        shape.beside = neighbours(&shape.cubes);
        Ok(shape)
    }

    /// Nodes whose places a state gives.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// The size of the pieces, mm.
    pub fn piece_mm(&self) -> f64 {
        self.piece_mm
    }

    /// Where the organ is at rest.
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// Where the nodes at these places have a place of the organ at rest, mm in the organ's frame. One a little outside all cubes goes with the nearest, as
    /// cubes with hardly any tissue are left out of a mesh; `None` farther than half its side.
    pub fn moved(&self, places: &[[f32; 3]], at: [f64; 3]) -> Option<[f64; 3]> {
        let lattice: [f64; 3] = std::array::from_fn(|a| (at[a] - self.origin[a]) / self.piece_mm);
        // In pieces; 0 inside.
        let outside = |cube: &Placed| {
            let along = |a: usize| lattice[a] - f64::from(cube.corner[a]);
            let beyond = |a: usize| (-along(a)).max(along(a) - f64::from(cube.span));
            (0..3).map(beyond).fold(0.0, f64::max)
        };
        let far = || self.cubes.iter().map(|cube| (cube, outside(cube)));
        // On a face that cubes share each of them has the same place.
        let inside = far().find(|(_, off)| *off == 0.0);
        let (cube, off) = inside.or_else(|| far().min_by(|a, b| a.1.total_cmp(&b.1)))?;
        if off > MOST_OUTSIDE * f64::from(cube.span) {
            return None;
        }
        let local = [0, 1, 2].map(|a| weights((lattice[a] - f64::from(cube.corner[a])) / f64::from(cube.span)));
        Some(quadratic::at(
            &cube.nodes.map(|n| places[n as usize].map(f64::from)),
            &local,
        ))
    }

    fn place(&self, cube: &Cube) -> Result<Placed, String> {
        let span = whole(cube.side / self.piece_mm).filter(|n| (*n as u32).is_power_of_two());
        let span =
            span.ok_or_else(|| format!("a side of {} mm; powers of two of the smallest are allowed", cube.side))?;
        let mut corner = [0; 3];
        for (a, at) in corner.iter_mut().enumerate() {
            *at = whole((cube.low[a] - self.origin[a]) / self.piece_mm)
                .ok_or_else(|| format!("its corner {:?} mm is not on the lattice of the others", cube.low))?;
        }
        Ok(Placed {
            nodes: cube.nodes,
            corner,
            span,
            held: Vec::new(),
            uniform: None,
        })
    }

    fn all_held(&self, cube: &Placed) -> Vec<Held> {
        let (span, corner) = (cube.span, cube.corner);
        let piece = |k: i32| [k % span, k / span % span, k / (span * span)];
        let corners = (0..span.pow(3)).map(|k| std::array::from_fn(|a| corner[a] + piece(k)[a]));
        corners.map(|corner| self.held(corner)).collect()
    }

    fn held(&self, corner: [i32; 3]) -> Held {
        let low = self.at(corner);
        let [least, most] = self.region.bounds(low, low.map(|x| x + self.piece_mm));
        match (least < 0.0, most < 0.0) {
            (false, _) => Held::Nothing,
            (true, false) => Held::Part,
            (true, true) => Held::All,
        }
    }

    /// The place of a corner of the lattice at rest, mm.
    pub(super) fn at(&self, corner: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.origin[a] + self.piece_mm * f64::from(corner[a]))
    }
}

/// A whole number that is one, within what rounding leaves of it.
fn whole(x: f64) -> Option<i32> {
    let near = x.round();
    ((x - near).abs() <= OFF_LATTICE && near.abs() < 1e9).then_some(near as i32)
}

/// The smallest side halved until it is no larger than wanted.
fn piece(least: f64, most: f64, wanted: f64) -> Option<f64> {
    if wanted.is_nan() || wanted <= 0.0 {
        return None;
    }
    let sizes = (0..=6).map(|k| least / f64::from(1 << k));
    let fits = |size: &f64| *size <= wanted * (1.0 + 1e-9) && most / size <= f64::from(MOST_PIECES) * (1.0 + 1e-9);
    sizes.into_iter().find(fits)
}

fn check(k: usize, cube: &Cube, nodes: usize) -> Result<(), NoShape> {
    let refused = |why: String| Err(NoShape::Cube { cube: k, why });
    if !(cube.side > 0.0 && cube.side.is_finite() && cube.low.iter().all(|x| x.is_finite())) {
        return refused(format!("a side of {} mm at {:?} mm", cube.side, cube.low));
    }
    match cube.nodes.iter().find(|n| **n as usize >= nodes) {
        Some(node) => refused(format!("node {node} of {nodes}")),
        None => Ok(()),
    }
}

fn count(what: &'static str, found: u64, allowed: u64) -> Result<(), NoShape> {
    if (1..=allowed).contains(&found) {
        return Ok(());
    }
    Err(NoShape::Count { what, found, allowed })
}
