//! The frame of reference and the patient of an examination, for what must be of the same.

use scene::{VolumeSource, VolumeSpec};

use crate::dicom::{self, Reference};
use crate::source::ReadError;

/// What an examination says of both, never shown; nothing where it is no DICOM.
///
/// # Errors
/// [`ReadError`] of the examination.
pub(crate) fn reference_of(examination: Option<&VolumeSpec>) -> Result<Reference, ReadError> {
    let Some(VolumeSource::File(file)) = examination.map(|examination| &examination.source) else {
        return Ok(Reference::default());
    };
    let series = file.series.map(|number| number as usize);
    Ok(dicom::reference(&file.path, series)?)
}
