//! Why a label map has no index, and why a tube is not one.

use std::fmt;

/// What was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// Where the tube enters.
    Entry,
    /// Where it ends.
    Tip,
    /// Its radius.
    Radius,
    /// Its length.
    Length,
    /// The distance within which structures are searched.
    Within,
    /// The number of sections.
    Sections,
    /// Where a part of the tube begins or ends.
    Part,
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Entry => "entry of the tube",
            Self::Tip => "tip of the tube",
            Self::Radius => "radius of the tube",
            Self::Length => "length of the tube",
            Self::Within => "distance to search within",
            Self::Sections => "number of sections",
            Self::Part => "depth of a part of the tube",
        })
    }
}

/// Why a tube or a question about it was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TubeError {
    /// A number is NaN or infinite.
    #[error("{what}: {found} is not a finite number")]
    NotFinite {
        /// Which input.
        what: Input,
        /// The number found.
        found: f64,
    },
    /// A number is outside its domain; of a radius, zero is.
    #[error("{what}: {found} is outside {} to {}", allowed[0], allowed[1])]
    OutOfRange {
        /// Which input.
        what: Input,
        /// The number found.
        found: f64,
        /// The least and the largest.
        allowed: [f64; 2],
    },
    /// Entry and tip are the same place, so that there is no axis.
    #[error("entry of the tube: {distance_mm} mm from its tip, an axis needs at least {least_mm} mm")]
    EntryIsTip {
        /// Their distance, mm.
        distance_mm: f64,
        /// The least distance, mm.
        least_mm: f64,
    },
}

/// Why a label map was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    /// A slice has more voxels than are kept in memory.
    #[error("the label map has slices of {voxels} voxels, at most {allowed} are allowed")]
    SliceTooLarge {
        /// Voxels of a slice.
        voxels: u64,
        /// The most.
        allowed: u64,
    },
    /// A slice does not have the number of labels that the grid asks for.
    #[error("slice {z} of the label map: {found} labels, the grid has {expected} voxels a slice")]
    SliceSize {
        /// Which slice.
        z: u32,
        /// The labels found.
        found: usize,
        /// Voxels of a slice.
        expected: usize,
    },
    /// There are more or fewer slices than the grid has.
    #[error("the label map has {found} slices, its grid {expected}")]
    Slices {
        /// The slices found; of too many, those that were looked at.
        found: u64,
        /// Those of the grid.
        expected: u32,
    },
    /// A label is below zero: no structure has such a number, and voxels that nobody wrote have it.
    #[error("the label map has the label {found} at voxel {voxel:?}; labels are 0 (background) to 32767")]
    Negative {
        /// The first such voxel of its slice.
        voxel: [u32; 3],
        /// Its label.
        found: i16,
    },
    /// Not one voxel has a label, so that nothing could be said of any structure.
    #[error("the label map is empty: all of its {voxels} voxels are background")]
    Empty {
        /// Voxels of the map.
        voxels: u64,
    },
    /// The structures are too ragged for the memory of their index.
    #[error(
        "the structures of the label map take more than {allowed} bytes: {boundary} boundary voxels in the first {slices} of \
         {of} slices"
    )]
    TooLarge {
        /// The most bytes.
        allowed: u64,
        /// Boundary voxels found so far.
        boundary: u64,
        /// Slices looked at.
        slices: u32,
        /// Slices of the map.
        of: u32,
    },
}
