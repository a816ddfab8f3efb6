//! Why an examination was not written.

use std::path::{Path, PathBuf};

use crate::source::ReadError;

/// Why a file was not written. Nothing is left of it then, and what was at its path before is still there.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The name does not say which format is meant, or cannot stand in a header.
    #[error("{}: expected {expected}", path.display())]
    Name {
        /// The path.
        path: PathBuf,
        /// Names that would do.
        expected: &'static str,
    },
    /// The format cannot hold voxels that lie like this.
    #[error(
        "{}: MetaImage holds axes at right angles only, and axes {} and {} meet at {degrees:.3} degrees (a tilted \
         gantry?); write NRRD (.nrrd) or NIfTI (.nii.gz) instead",
        path.display(), axes[0], axes[1]
    )]
    Sheared {
        /// The path.
        path: PathBuf,
        /// Which two axes, 0 to 2.
        axes: [usize; 2],
        /// The angle between them.
        degrees: f64,
    },
    /// The operating system refused.
    #[error("{}: cannot {doing}: {source}", path.display())]
    Io {
        /// The path.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The examination could not be read.
    #[error("{}: not written: {source}", path.display())]
    Read {
        /// The path.
        path: PathBuf,
        /// Why.
        source: ReadError,
    },
}

/// The system's reason with what was being done to `path`.
pub(crate) fn io(path: &Path, doing: &'static str) -> impl Fn(std::io::Error) -> WriteError {
    move |source| WriteError::Io {
        path: path.to_owned(),
        doing,
        source,
    }
}
