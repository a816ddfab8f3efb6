//! What a filter can do for the drawing of an image.

use std::ops::Range;

use super::patch::{Patches, Plan};
use super::region::Region;
use super::vector::Vector;
use super::walk::{LANES, Walk};

/// A filter with what it reads.
pub(super) trait Kernel {
    /// The proof that it may use vector instructions.
    fn vector(&self) -> Option<Vector>;

    /// Draws `columns`, one after the other.
    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]);

    /// If it can do whole blocks at once: how far before and behind a point its taps lie, voxels.
    fn whole_blocks(&self) -> Option<[f64; 2]> {
        None
    }

    /// Draws whole blocks from block `first` on, all of them within [`Kernel::whole_blocks`] of the outermost voxels.
    fn blocks(&self, walk: &Walk, first: usize, line: &mut [f32]) {
        self.points(walk, first * LANES..first * LANES + line.len(), line);
    }

    /// If it can draw from copies: how far its taps are from a point at most, voxels.
    fn reach(&self) -> Option<i32> {
        None
    }

    /// Plans the copy of what the points of a tile need.
    fn plan(&self, _: &Region, _: &mut Plan) {}

    /// Asks for a part of the memory of what will be copied next.
    fn fetch(&self, _: &Plan, _part: usize, _parts: usize) {}

    /// Copies it.
    fn copy(&self, _: &Plan, _: &mut Patches) {}

    /// Draws `columns`, which are inside the volume, from the copy of what their tile needs.
    fn copied(&self, _: &Patches, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        self.points(walk, columns, line);
    }
}
