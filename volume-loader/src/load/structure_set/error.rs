//! Why a structure set is not read.

use std::path::PathBuf;

use crate::dicom::error::DicomError;
use crate::load::origin::error::OriginError;
use crate::source::ReadError;

/// Why a structure set gives no points.
#[derive(Debug, thiserror::Error)]
pub enum StructureSetError {
    /// It cannot be read, or an element is not what it must be.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A region of interest of several points.
    #[error("{}: region of interest {number} ({name:?}) is {found} points: which of them is meant, is not known", path.display())]
    Several {
        /// The file.
        path: PathBuf,
        /// ROINumber.
        number: u64,
        /// ROIName.
        name: String,
        /// How many.
        found: usize,
    },
    /// It is of another patient, or was rejected.
    #[error("{}: {source}", path.display())]
    Origin {
        /// The file.
        path: PathBuf,
        /// Why.
        source: OriginError,
    },
    /// It belongs to another examination.
    #[error(
        "{}: region of interest {number} ({name:?}) is in another frame of reference than the examination or the points before it \
         (ReferencedFrameOfReferenceUID): it is a place in another scan, or of another patient", path.display()
    )]
    OtherFrame {
        /// The file.
        path: PathBuf,
        /// ROINumber.
        number: u64,
        /// ROIName.
        name: String,
    },
}

impl From<DicomError> for StructureSetError {
    fn from(error: DicomError) -> Self {
        Self::Read(error.into())
    }
}
