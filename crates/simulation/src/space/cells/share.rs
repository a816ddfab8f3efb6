//! What moves a place of the reference configuration, with derivatives by the place.

use nalgebra::{Matrix3, Vector3};

use super::grid::Cell;
use super::mesh::Mesh;
use super::shape::{curvatures, gradients, values};

/// A place may be so far outside all cubes, in sides of the largest, and is moved by the polynomial of the nearest.
const MARGIN: f64 = 0.5;
/// Steps of the search for it: powers of two up to the margin.
const PROBES: i32 = 5;

/// A free node's part in the displacement of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// The node.
    pub node: u32,
    /// Its weight.
    pub weight: f64,
    /// The weight's derivative by the reference place.
    pub slope: Vector3<f64>,
    /// The second derivative.
    pub curvature: Matrix3<f64>,
}

impl Mesh {
    /// Free nodes and what they are to the displacement of a place, each once. A place outside all cubes, by half a side of the
    /// largest at most, is moved by the polynomial of the nearest cube: where two cubes share a face, both agree on all of its
    /// plane, so the displacement is continuous outside as well. `None` farther away.
    pub fn shares(&self, at: &Vector3<f64>) -> Option<Vec<Share>> {
        let cell = self.grid.containing(at).or_else(|| self.nearest_cell(at))?;
        let number = self.cells.binary_search(&cell).ok()?;
        let (local, scale) = (self.grid.local(&cell, at), 2.0 / self.grid.length(cell.span));
        let (values, slopes) = (values(self.order, local), gradients(self.order, local));
        let curvatures = curvatures(self.order, local);
        let mut shares = Vec::with_capacity(2 * values.len());
        for (k, node) in self.ties.of_cell[number].iter().enumerate() {
            for (free, part) in &self.ties.ties[*node as usize] {
                shares.push(Share {
                    node: *free,
                    weight: part * values[k],
                    slope: slopes[k] * (scale * part),
                    curvature: curvatures[k] * (scale * scale * part),
                });
            }
        }
        // Stable: sums are in one order.
        shares.sort_by_key(|share| share.node);
        shares.dedup_by(|other, one| {
            let same = one.node == other.node;
            if same {
                one.weight += other.weight;
                one.slope += other.slope;
                one.curvature += other.curvature;
            }
            same
        });
        Some(shares)
    }

    /// The cube nearest to a place outside all, within the margin.
    fn nearest_cell(&self, at: &Vector3<f64>) -> Option<Cell> {
        let largest = self.cells.iter().map(|cell| cell.span).max()?;
        let margin = MARGIN * self.grid.length(largest);
        let mut best: Option<(f64, Cell)> = None;
        for probe in (0..PROBES).rev() {
            let step = margin / f64::from(1 << probe);
            // A cube at less than the step along one axis, two or three is hit by one of these.
            let found = best.is_some();
            for k in 0..27 {
                let way = Vector3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).map(f64::from) * step;
                if let Some(cell) = self.grid.containing(&(at + way)) {
                    let [low, high] = self.grid.corners(&cell);
                    let apart = (at - low.sup(&high.inf(at))).norm();
                    if best.is_none_or(|(least, _)| apart < least) && apart <= margin {
                        best = Some((apart, cell));
                    }
                }
            }
            // One step more: a nearer one may lie straight ahead.
            if found {
                break;
            }
        }
        best.map(|(_, cell)| cell)
    }
}
