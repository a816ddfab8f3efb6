//! Why a sequence cannot be played.

use std::io;
use std::path::PathBuf;

use calib::file::sequence::SequenceError;
use geometry::uncertain::CovarianceError;

/// The longest header, bytes.
pub(super) const MAX_BYTES: u64 = 64 << 20;
/// Times that a sequence may have, s: nine years, and its nanoseconds fit into 64 bits.
pub(super) const MAX_S: f64 = 3e8;

/// Why a sequence cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum PlayError {
    /// The file cannot be read.
    #[error("reading the sequence {path}: {source}. Check tracker.sequence.file in the scene")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It has no header of a sequence.
    #[error("reading the sequence {path}: no line ElementDataFile within {MAX_BYTES} bytes of text; is it a sequence?")]
    NoHeader {
        /// The file.
        path: PathBuf,
    },
    /// A line of it is wrong, or a transform is not there.
    #[error("reading the sequence {path}: {source}")]
    Sequence {
        /// The file.
        path: PathBuf,
        /// What and where.
        source: SequenceError,
    },
    /// Several transforms and none is named.
    #[error("reading the sequence {path}: several transforms: {found}; name the tool's with tracker.sequence.marker")]
    SeveralTransforms {
        /// The file.
        path: PathBuf,
        /// Their names.
        found: String,
    },
    /// A frame has no time.
    #[error(
        "reading the sequence {path}: frame {frame} has no time stamp of at most {MAX_S:e} s; when was it captured?"
    )]
    NoTime {
        /// The file.
        path: PathBuf,
        /// Its number.
        frame: u32,
    },
    /// The noise is no covariance.
    #[error("tracker.sequence.noise_mm and noise_deg: {0}")]
    Noise(#[from] CovarianceError),
}
