//! DICOM segmentations as label maps: Segmentation Storage (BINARY, and FRACTIONAL whose voxels are whole) and Label Map Segmentation
//! Storage (DICOM PS3.3, A.51).
//!
//! A voxel is the number of its segment. Frames lie where their own places and axes put them, on one even grid; those that a writer left
//! out are planes without a structure, as the standard has it. What would be a guess is refused: voxels of two segments, voxels that are
//! partly of one, planes between which no step leads, and a frame of reference or a patient that is not the examination's; and what was
//! looked at and rejected.

mod error;
mod groups;
mod lattice;
mod object;
mod source;

#[cfg(test)]
mod tests;

use std::path::Path;

use scene::VolumeSpec;

pub use error::SegmentationError;
pub(crate) use source::SegmentationSource;

use super::origin::{Belongs, reference_of};
use crate::dicom;
use crate::source::ReadError;

/// Opens the segmentation at `path`, which must share the frame of reference and what both say of the patient with `examination`, where
/// that is DICOM too; `None` where it is no segmentation. With how it belongs to that.
///
/// # Errors
/// [`ReadError`].
pub(crate) fn open(
    path: &Path,
    examination: Option<&VolumeSpec>,
) -> Result<Option<(SegmentationSource, Belongs)>, ReadError> {
    if !dicom::has_preamble(path) {
        return Ok(None);
    }
    let Some(mut source) = SegmentationSource::open(path)? else {
        return Ok(None);
    };
    let reference = reference_of(examination)?;
    let refused = |source| {
        Err(ReadError::Segmentation {
            path: path.to_owned(),
            source,
        })
    };
    let doubts = match source.check_origin(&reference) {
        Ok(doubts) => doubts,
        Err(error) => return refused(error.into()),
    };
    let is_in_its_frame = !reference.frames.is_empty();
    if is_in_its_frame && !reference.frames.contains(source.frame_of_reference()) {
        return refused(SegmentationError::OtherFrame);
    }
    let belongs = Belongs {
        is_in_its_frame,
        doubts,
    };
    Ok(Some((source, belongs)))
}
