//! Why there are no beads, no match and no check.

use std::path::{Path, PathBuf};

use crate::bounds::NotJudged;
use crate::input_files::source::SourceError;
use crate::live::LiveError;
use crate::register::file::ReadError;
use crate::register::input_error::InputError;
use crate::register::solve::SolveError;
use crate::store::StoreError;

/// Why a command of this folder failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BeadsError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error(transparent)]
    NotJudged(#[from] NotJudged),
    #[error(transparent)]
    Input(#[from] InputError),
    #[error(transparent)]
    Solve(#[from] SolveError),
    #[error(transparent)]
    Registration(#[from] ReadError),
    #[error(transparent)]
    Picture(#[from] picture::PngError),
    /// The volume was not read; the text says what and where.
    #[error("{0}")]
    Volume(Box<dyn std::error::Error + Send + Sync>),
    #[error(
        "{path} is not a CT but of the modality {modality}: its numbers are not HU, and neither bone nor metal is told by them; \
         --accept-not-ct takes them as HU all the same"
    )]
    NotCt { path: PathBuf, modality: String },
    #[error("{path}: --spacing-mm is the generated patient's (`phantom`); a file has its own")]
    SpacingOfFile { path: PathBuf },
    #[error("finding beads in {path}: {refused}")]
    Find { path: PathBuf, refused: Box<bead::Refused> },
    #[error("matching the touched points of {touched} to the beads of {beads}: {refused}")]
    Match {
        beads: PathBuf,
        touched: PathBuf,
        refused: Box<bead::matching::Refused>,
    },
    #[error("reading the beads {path}: {source}")]
    Json { path: PathBuf, source: serde_json::Error },
    #[error("reading the beads {path}: {what}; find the beads again, or take the file that calib beads wrote")]
    BadBeads { path: PathBuf, what: String },
    #[error(
        "the beads {path} were found in the CT {found}, and {expected} is used ({by}): find the beads in that CT, or take \
         the file made from it"
    )]
    OtherCt {
        path: PathBuf,
        found: String,
        expected: String,
        by: String,
    },
    #[error("checking with the registration {path}: {what}")]
    Unusable { path: PathBuf, what: String },
    #[error("writing the result as JSON: {0}")]
    Encode(#[from] serde_json::Error),
}

/// A registration that cannot be checked, and why.
pub(super) fn unusable(path: &Path, what: impl Into<String>) -> BeadsError {
    BeadsError::Unusable {
        path: path.to_owned(),
        what: what.into(),
    }
}
