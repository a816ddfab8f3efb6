//! NIfTI-1 and NIfTI-2 in one file, plain or gzip: `.nii`, `.nii.gz`.
//!
//! NIfTI's axes are RAS (+x Right, +y Anterior, +z Superior); ours are LPS. The change, x and y negated, is made in
//! the private module `orientation` and nowhere else. Format: nifti1.h and nifti2.h, <https://nifti.nimh.nih.gov>.

mod error;
mod fields;
mod header;
mod meaning;
mod orientation;
mod reader;
mod writer;

#[cfg(test)]
mod tests;

pub use error::HeaderError;
pub use orientation::is_sheared;
pub use reader::NiftiSource;
pub use writer::write;

pub use crate::write::error::WriteError;
