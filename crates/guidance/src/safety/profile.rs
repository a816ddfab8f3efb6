//! The nearest structure along a tube's way: what a chart of distance over depth shows.

use super::clearance::Nearest;
use super::coverage::Coverage;
use super::placed::Placed;
use super::refusal::{Input, TubeError};
use super::sections::Sections;
use super::slab::Slab;
use super::structures::Structures;
use super::tube::{MAX_LENGTH_MM, Tube, within};

/// The most sections of a tube.
pub const MAX_SECTIONS: usize = 10_000;

/// A section of a tube: what it holds between two depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Where it begins, mm.
    pub from_mm: f64,
    /// Where it ends, mm.
    pub to_mm: f64,
    /// The label and the voxel nearest to the section; `None` where none is nearer than was searched.
    ///
    /// The distance is that of the voxel's centre from the section, a solid cylinder of the tube's radius; of a centre within the
    /// section it is the signed distance from the whole tube, below zero.
    pub nearest: Option<(i16, Nearest)>,
    /// Whether the whole section lies in the label map's field. Where it does not, it is NOT CHECKED, whatever is nearest.
    pub is_inside_map: bool,
}

impl Structures {
    /// The structure nearest to each of `sections` equal sections of the tube, from the entry on, exactly where it is nearer
    /// than `within_mm`.
    ///
    /// Together the sections are the tube, and nothing lies between them: the least of their distances is the least of
    /// [`Structures::clearance`], however few they are. Error: as there.
    ///
    /// # Errors
    /// [`TubeError`] of `within_mm`, which is 0 to [`MAX_LENGTH_MM`], and of `sections`, which is 1 to [`MAX_SECTIONS`].
    pub fn profile(&self, tube: &Tube, sections: usize, within_mm: f64) -> Result<Vec<Section>, TubeError> {
        within(Input::Within, within_mm, [0.0, MAX_LENGTH_MM])?;
        within(Input::Sections, sections as f64, [1.0, MAX_SECTIONS as f64])?;
        let placed = Placed::new(tube, &self.grid);
        let coverage = Coverage::of(tube, &self.grid);
        // The share first, so that the last section ends where the tube does to the last bit.
        let depth = |k: usize| tube.length_mm() * (k as f64 / sections as f64);
        let slab = |k| Slab {
            from: depth(k),
            to: depth(k + 1),
        };
        let slabs: Vec<Slab> = (0..sections).map(slab).collect();
        let search = Sections::new(self, &placed, slabs.clone(), within_mm);
        let section = |(k, slab): (usize, Slab)| Section {
            from_mm: slab.from,
            to_mm: slab.to,
            nearest: search
                .found(k)
                .map(|(label, found)| (label, Nearest::of(found, &self.grid))),
            is_inside_map: coverage.holds(slab.from, slab.to),
        };
        Ok(slabs.into_iter().enumerate().map(section).collect())
    }
}
