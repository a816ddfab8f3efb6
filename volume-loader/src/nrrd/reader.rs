//! An NRRD file as an examination.

use std::path::Path;

use super::header;
use crate::raster::{Head, OpenOptions, RasterSource};
use crate::source::ReadError;

/// Opens the NRRD header or file at `path` and judges it; no voxel is read yet.
///
/// # Errors
/// [`ReadError::Nrrd`] for the header; for its files each variant that tells of a file, its length or its beginning.
pub fn open(path: &Path, options: OpenOptions) -> Result<RasterSource, ReadError> {
    let mut head = Head::read(path)?;
    let data = header::parse(path, &mut head, options).map_err(|source| ReadError::Nrrd {
        path: path.to_owned(),
        source,
    })?;
    RasterSource::open(data)
}
