//! How far a tube stays from each structure.

use geometry::{Ct, Point, VolumeGrid};

use super::coverage::Coverage;
use super::placed::{Line, Placed};
use super::refusal::{Input, TubeError};
use super::search::{Found, Search};
use super::structures::{Structure, Structures};
use super::tube::{MAX_LENGTH_MM, Tube, within};

/// The voxel of a structure that is nearest to a tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The signed distance of its centre from the solid tube, mm: outside it that from the tube's nearest point; inside it less
    /// than zero, by the distance from the tube's nearest surface.
    pub distance_mm: f64,
    /// The depth of its centre, from the entry along the axis, mm: less than zero behind the entry, more than the length beyond the tip.
    pub depth_mm: f64,
    /// Its index in the label map.
    pub voxel: [u32; 3],
    /// Its centre.
    pub point: Point<Ct>,
}

impl Nearest {
    pub(super) fn of(found: Found, grid: &VolumeGrid) -> Self {
        let [x, y, z] = found.voxel.map(f64::from);
        Self {
            distance_mm: found.signed_mm,
            depth_mm: found.depth_mm,
            voxel: found.voxel,
            point: grid.ct_from_voxel() * Point::new(x, y, z),
        }
    }
}

/// What is known of a structure beside a tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distance {
    /// Its nearest voxel. Of several at the same distance, one.
    Nearest(Nearest),
    /// No voxel's centre is nearer than this, mm; it was not searched farther.
    Beyond {
        /// The distance searched.
        within_mm: f64,
    },
}

/// A tube beside one structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// The structure's label.
    pub label: i16,
    /// Its distance from the tube, by the centres of its voxels.
    pub distance: Distance,
    /// Whether the tube cuts the structure for certain: the centre of one of its voxels lies in the tube, or the tube's axis runs
    /// through the cell of one. A tube within a structure cuts it.
    pub cuts: bool,
    /// From a voxel's centre to the farthest corner of its cell, mm.
    pub voxel_half_diagonal_mm: f64,
    /// [`Coverage::margin_mm`] of the tube.
    pub margin_mm: f64,
}

impl Clearance {
    /// The distance by the centres of voxels, mm: that of the nearest, or that which was searched.
    pub fn distance_mm(&self) -> f64 {
        match self.distance {
            Distance::Nearest(nearest) => nearest.distance_mm,
            Distance::Beyond { within_mm } => within_mm,
        }
    }

    /// Whether no cell of the structure's voxels meets the tube. Not every tube for which this is false cuts it: see [`Clearance::cuts`].
    pub fn is_clear(&self) -> bool {
        self.distance_mm() > self.voxel_half_diagonal_mm
    }

    /// Whether no cell of the structure's voxels meets the tube, also where the tube is off its place by the predicted error; where that is
    /// not known, as [`Clearance::is_clear`]. Of what lies beyond the map's field it says nothing.
    pub fn is_clear_within(&self, predicted_error_mm: Option<f64>) -> bool {
        self.distance_mm() - self.voxel_half_diagonal_mm > predicted_error_mm.unwrap_or(0.0)
    }

    /// The distance that the structure keeps at least, mm; less than zero where it may be cut by so much.
    ///
    /// A cell reaches half its diagonal beyond its centre, and beyond the map's field, [`Coverage::margin_mm`] away, the structure may
    /// go on unseen; the tube is off its place by no more than `predicted_error_mm`. Not known, and `None`, where that error is not known
    /// (or is no number, or below zero), and where the tube leaves the field. What the label map itself has wrong is not in it.
    pub fn at_least_mm(&self, predicted_error_mm: Option<f64>) -> Option<f64> {
        let error = predicted_error_mm.filter(|error| error.is_finite() && *error >= 0.0)?;
        let seen = (self.distance_mm() - self.voxel_half_diagonal_mm).min(self.margin_mm);
        (self.margin_mm >= 0.0).then_some(seen - error)
    }
}

/// A tube beside all structures of a label map.
#[derive(Debug, Clone, PartialEq)]
pub struct Clearances {
    /// Where the tube lies within the map's field. Outside it nothing below says anything.
    pub coverage: Coverage,
    /// One for each structure, nearest first; by label where the distances are the same.
    pub structures: Vec<Clearance>,
}

impl Structures {
    /// How far the tube stays from each structure: exactly where that is less than `within_mm`, or than half a voxel's diagonal
    /// where that is more.
    ///
    /// The distance is the least of the signed distances of all centres of the structure's voxels. Error: 32 eps times the largest
    /// coordinate of the tube and of the map's corners, mm.
    ///
    /// # Errors
    /// [`TubeError`] of `within_mm`, which is 0 to [`MAX_LENGTH_MM`].
    pub fn clearance(&self, tube: &Tube, within_mm: f64) -> Result<Clearances, TubeError> {
        within(Input::Within, within_mm, [0.0, MAX_LENGTH_MM])?;
        // What may be cut is always searched.
        let half_diagonal = self.lattice.half_diagonal_mm;
        let limit = within_mm.max(half_diagonal * (1.0 + 1e-9));
        let (placed, line) = (Placed::new(tube, &self.grid), Line::new(tube, &self.grid));
        let coverage = Coverage::of(tube, &self.grid);
        let mut search = Search::new(&placed, self.lattice.reach_mm);
        let mut beside = |structure: &Structure| {
            let found = search.nearest(structure, limit);
            let distance = found.map_or(limit, |found| found.signed_mm);
            Clearance {
                label: structure.label(),
                distance: found.map_or(Distance::Beyond { within_mm: limit }, |found| {
                    Distance::Nearest(Nearest::of(found, &self.grid))
                }),
                cuts: distance <= 0.0
                    || distance <= half_diagonal && search.is_pierced(structure, &line, half_diagonal),
                voxel_half_diagonal_mm: half_diagonal,
                margin_mm: coverage.margin_mm,
            }
        };
        let mut structures: Vec<Clearance> = self.list.iter().map(&mut beside).collect();
        // Stable, and by label before.
        structures.sort_by(|a, b| a.distance_mm().total_cmp(&b.distance_mm()));
        Ok(Clearances { coverage, structures })
    }
}
