//! The frame of reference of an examination, for what must be in the same.

use scene::{VolumeSource, VolumeSpec};

use crate::dicom;
use crate::source::ReadError;

/// The frame of reference of an examination, never shown; `None` where it is no DICOM, or says none.
///
/// # Errors
/// [`ReadError`] of the examination.
pub(crate) fn frame_of(examination: Option<&VolumeSpec>) -> Result<Option<String>, ReadError> {
    let Some(VolumeSource::File(file)) = examination.map(|examination| &examination.source) else {
        return Ok(None);
    };
    let series = file.series.map(|number| number as usize);
    Ok(dicom::frame_of_reference(&file.path, series)?)
}
