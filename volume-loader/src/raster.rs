//! Volumes that a text header describes: what NRRD and MetaImage share.
//!
//! A header names the voxels' files and how they are stored; [`RasterSource`] reads them. Formats differ only in their
//! headers, in the modules `nrrd` and `metaimage`.

mod claims;
mod data;
mod head;
mod names;
mod quote;
mod remarks;
mod sequence;
mod slices;
mod source;
mod text;
pub(crate) mod trail;

#[cfg(test)]
pub(crate) mod test_files;

pub(crate) use claims::{Claims, is_hu};
pub(crate) use data::{Data, Encoding, Part, Skip};
pub(crate) use head::Head;
pub(crate) use names::FileList;
pub use names::NamesError;
pub(crate) use quote::{numbers, quote};
pub(crate) use remarks::Remarks;
pub(crate) use slices::PlainSlices;
pub use source::RasterSource;

/// HU for what is not a number; neither format names a padding of its own. What scanners write outside their circle.
pub(crate) const PADDING_HU: i16 = -1024;

/// What a caller vouches for beyond what a file says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OpenOptions {
    /// Takes the axes of a file that tells no orientation as LPS (x to the patient's left, y to the back, z up), and a
    /// missing origin as 0. Without it such a file is refused.
    pub assume_lps: bool,
}
