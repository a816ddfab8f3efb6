//! What can be wrong with a recording of poses.

use std::io;
use std::path::PathBuf;

use calib::file::sequence::SequenceError;
use geometry::rotation::RotationError;
use geometry::uncertain::CovarianceError;

use super::{MAX_POSES, MOST_OFF};
use crate::input_files::source::{MAX_BYTES, SourceError};
use crate::register::input_error::Place;

/// Why a recording gave no poses. Lines and columns count from 1.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PosesError {
    /// A file could not be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A folder, or a file of a kind that is read in parts, could not be read.
    #[error("reading {path}: {source}. Check the name and the permissions")]
    Read { path: PathBuf, source: io::Error },
    /// There is nothing in it.
    #[error("reading {path}: there is no pose in it; {expected}")]
    NoPoses { path: PathBuf, expected: &'static str },
    /// Every frame is marked as not valid.
    #[error("reading {path}: none of its {frames} frames holds a valid pose of {name}")]
    NoneValid { path: PathBuf, frames: usize, name: String },
    /// Too much of it.
    #[error(
        "reading {path}: more than {MAX_POSES} poses or {MAX_BYTES} bytes; cut the recording to the calibration's part"
    )]
    TooMany { path: PathBuf },
    /// A field that is not what it must be.
    #[error("reading {place}: found {found:?}, expected {expected}")]
    Field {
        place: Place,
        found: String,
        expected: &'static str,
    },
    /// More or fewer numbers than a pose has.
    #[error("reading {path}: line {line}: {found} {what}, expected {expected}")]
    Count {
        path: PathBuf,
        line: usize,
        found: usize,
        what: &'static str,
        expected: usize,
    },
    /// A quote that does not close.
    #[error("reading {path}: line {line}, column {column}: the quoted field does not end in a quote and a comma")]
    BadQuote { path: PathBuf, line: usize, column: usize },
    /// A column that must be there is not.
    #[error("reading {path}: line {line}: the header has no column {missing}; expected {hint}")]
    MissingColumn {
        path: PathBuf,
        line: usize,
        missing: &'static str,
        hint: &'static str,
    },
    /// A column that means nothing, or is there twice.
    #[error("reading {place}: this column is not known, or is there a second time; expected {hint}")]
    BadColumn { place: Place, hint: &'static str },
    /// A matrix without a rotation near it.
    #[error("reading {path}: line {line}: the matrix holds no rotation: {source}")]
    NoRotation {
        path: PathBuf,
        line: usize,
        source: RotationError,
    },
    /// A matrix or quaternion too far from a rotation.
    #[error(
        "reading {path}: line {line}: the rotation is off by {distance:.2e} (Frobenius norm to the nearest one), at most \
         {MOST_OFF:e} is accepted; is there a scale in it, or are rows and columns exchanged?"
    )]
    FarFromRotation { path: PathBuf, line: usize, distance: f64 },
    /// The covariance of a pose is none.
    #[error("reading {path}: line {line}: the columns c0 to c20 hold no covariance: {source}")]
    Covariance {
        path: PathBuf,
        line: usize,
        source: CovarianceError,
    },
    /// The last row is not that of a rigid transform.
    #[error("reading {path}: line {line}: the last row of the matrix is {found:?}, expected 0 0 0 1")]
    BottomRow {
        path: PathBuf,
        line: usize,
        found: [f64; 4],
    },
    /// A sequence that cannot be read.
    #[error("reading {path}: {source}")]
    Sequence { path: PathBuf, source: SequenceError },
    /// There are several transforms and none was asked for.
    #[error("reading {path}: there are several transforms: {found}; choose one with --transform")]
    SeveralTransforms { path: PathBuf, found: String },
    /// The header of a sequence does not end.
    #[error(
        "reading {path}: the header does not end in a line ElementDataFile within {MAX_BYTES} bytes; is it a sequence?"
    )]
    NoHeaderEnd { path: PathBuf },
    /// What `--strict` does not allow.
    #[error(
        "reading {path}: {backwards} time stamps go backwards, {same_time} are equal to the one before and {repeated} poses \
         are a repeat of the one before; --strict refuses these"
    )]
    Strict {
        path: PathBuf,
        backwards: usize,
        same_time: usize,
        repeated: usize,
    },
}
