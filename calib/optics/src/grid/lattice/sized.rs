//! A lattice of candidates with their sizes: what the fits of a grid begin with.

use std::collections::HashSet;

use crate::grid::candidates::blob::Blob;
use crate::grid::fit::disc_jacobian::point;
use crate::grid::found::GridSpec;
use crate::grid::homography::jacobian;
use crate::grid::lattice::Cell;
use crate::grid::lattice::assignment::View;
use crate::grid::lattice::index_lattice::IndexedLattice;
use crate::image::Image;

/// Marks are so much larger than other discs.
const MIN_MARK_SIZE: f64 = 1.6;
/// The share of the discs that must be seen.
pub(crate) const SEEN: f64 = 0.6;
/// A disc is there with half of the expected contrast.
pub(crate) const THERE: f64 = 0.5;

/// What the steps after the candidates work on.
pub(crate) struct Search<'a> {
    pub(crate) image: &'a Image,
    pub(crate) spec: &'a GridSpec,
    pub(crate) blobs: Vec<Blob>,
}

/// A lattice with what its candidates say of its discs.
pub(crate) struct SizedLattice {
    pub(crate) placed: IndexedLattice,
    /// Cells of discs of the usual size, by rows, and of large ones; none that the border cuts, whose size is not known.
    pub(crate) small: Vec<Cell>,
    pub(crate) marks: HashSet<Cell>,
    /// The usual radius beside the pitch.
    pub(crate) radius: f64,
}

impl Search<'_> {
    /// Radii beside the pitch, by area.
    fn radius(&self, placed: &IndexedLattice, cell: &Cell, i: usize) -> f64 {
        let area = jacobian(&placed.h, point(*cell)).determinant().abs();
        (self.blobs[i].area / std::f64::consts::PI / area).sqrt()
    }

    pub(crate) fn sized(&self, placed: IndexedLattice) -> SizedLattice {
        let uncut = placed.cells.iter().filter(|(_, i)| !self.blobs[**i].cut);
        let mut radii: Vec<(f64, Cell)> = uncut.map(|(c, i)| (self.radius(&placed, c, *i), *c)).collect();
        // Ties by the cell, as a hash map's order differs from run to run.
        radii.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // The median, as large discs are few; without any disc a usual sheet's radius.
        let middle = radii.get(radii.len() / 2).map_or(0.2, |r| r.0);
        let large = radii.partition_point(|r| r.0 <= MIN_MARK_SIZE * middle);
        let marks = radii[large..].iter().map(|r| r.1).collect();
        // A fit takes radii below half a pitch: it must start inside.
        let radius = radii.get(large / 2).map_or(0.2, |r| r.0).min(0.45);
        let mut small: Vec<Cell> = radii[..large].iter().map(|r| r.1).collect();
        small.sort_unstable_by_key(|c| [c[1], c[0]]);
        SizedLattice {
            placed,
            small,
            marks,
            radius,
        }
    }

    /// What is seen, for the decision which columns and rows it is.
    pub(crate) fn view<'b>(
        &'b self,
        sized: &'b SizedLattice,
        span: [[i32; 2]; 2],
        h: &nalgebra::Matrix3<f64>,
    ) -> View<'b> {
        let middle = span.map(|[a, b]| 0.5 * f64::from(a + b));
        let j = jacobian(h, middle.into());
        View {
            spec: self.spec,
            span,
            small: &sized.small,
            large: &sized.marks,
            axes: [j.column(0).into_owned(), j.column(1).into_owned()],
            candidates: self.blobs.len(),
        }
    }
}
