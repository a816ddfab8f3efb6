//! Why a series is not written.

use std::path::{Path, PathBuf};

use crate::source::ReadError;

/// Largest cosine of the angle between rows and columns: 0.005 mm over 500 mm for readers that make it a right angle.
pub(super) const MAX_SLANT: f64 = 1e-5;

/// Why a series was not written. Nothing is left of it then, and what was at its path before is still there.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Something else would be mixed with the series.
    #[error("{}: the folder is not empty (it holds {found}); name a new or an empty one", path.display())]
    NotEmpty {
        /// The folder.
        path: PathBuf,
        /// One of the names in it.
        found: String,
    },
    /// There is a file of this name.
    #[error("{}: this is a file, expected a folder; a DICOM series is one file per slice", path.display())]
    NotAFolder {
        /// The path.
        path: PathBuf,
    },
    /// Rows and columns are not perpendicular: the Image Plane module has no way to say so (PS3.3 C.7.6.2.1.1).
    #[error(
        "{}: rows and columns of the slices meet at {degrees:.4} degrees, and DICOM has right angles only (to {MAX_SLANT:e} rad); \
         write NIfTI, or resample the volume",
        path.display()
    )]
    Slanted {
        /// The folder.
        path: PathBuf,
        /// The angle.
        degrees: f64,
    },
    /// The operating system refused.
    #[error("{}: cannot {doing}: {source}", path.display())]
    Io {
        /// The folder or the file.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A slice could not be put into DICOM's form.
    #[error("{}: slice {slice} cannot be encoded: {detail}", path.display())]
    Encode {
        /// The folder.
        path: PathBuf,
        /// The slice.
        slice: u32,
        /// The encoder's reason.
        detail: String,
    },
    /// The examination could not be read.
    #[error("{}: not written: {source}", path.display())]
    Read {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: ReadError,
    },
}

/// Gives an I/O error its place.
pub(super) fn io(path: &Path, doing: &'static str) -> impl Fn(std::io::Error) -> ExportError {
    move |source| ExportError::Io {
        path: path.to_owned(),
        doing,
        source,
    }
}
