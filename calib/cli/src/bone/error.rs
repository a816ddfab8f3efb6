//! Why no bone is taken.

use std::path::PathBuf;

use crate::beads::BeadsError;
use crate::store::StoreError;

/// Why no bone is taken.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BoneError {
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The CT was not read.
    #[error(transparent)]
    Read(#[from] BeadsError),
    #[error(transparent)]
    Picture(#[from] picture::PngError),
    #[error("writing the surface {path}: its name must end in .ply or .vtk")]
    Ending { path: PathBuf },
    #[error("taking bone from {path}: {refused}{listed}")]
    Bone {
        path: PathBuf,
        refused: Box<bone::Refused>,
        listed: String,
    },
    #[error("label map {path}: {source}")]
    Labels {
        path: PathBuf,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    #[error("label map {path}: it does not lie on the CT's voxels ({found}); give the map that was made on this CT")]
    OtherGrid { path: PathBuf, found: String },
    #[error("label map {path}: there is no label {asked}; there are {known}")]
    NoLabel {
        path: PathBuf,
        asked: String,
        known: String,
    },
    #[error("writing the result as JSON: {0}")]
    Encode(#[from] serde_json::Error),
}
