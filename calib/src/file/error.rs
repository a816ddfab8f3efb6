//! Why a file is not used.

use std::fmt::Debug;

use super::{MAX_BYTES, quoted};

/// Why a file is not used; the name of the file is the caller's to put before it.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The text is longer than any such file.
    #[error("the file has {bytes} bytes; at most {MAX_BYTES} are read")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// The text is not JSON, or a key is missing or of a wrong type. Says line and column.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// It says it is something else, or of another version.
    #[error("found {found}, expected {expected}")]
    OtherVersion {
        /// What the file says it is.
        found: String,
        /// What is read here.
        expected: String,
    },
    /// It is of another kind than is needed.
    #[error("a calibration of kind {found:?}, {expected:?} is needed")]
    OtherKind {
        /// Its kind.
        found: String,
        /// The kind needed.
        expected: &'static str,
    },
    /// Its content is not what its id was made from.
    #[error("changed after it was written: its id is {found:?}, that of its content {computed:?}")]
    OtherId {
        /// The id in the file.
        found: String,
        /// The id of the content.
        computed: String,
    },
    /// It was not accepted when it was made.
    #[error("its verdict is {0:?}, only \"accepted\" is used")]
    NotAccepted(String),
    /// A number cannot be right.
    #[error("{key} is {found}, expected {expected}")]
    BadNumber {
        /// The key.
        key: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: String,
    },
    /// It was made for something else than is used.
    #[error("made for the {what} {found:?}, in use is {expected:?}")]
    WrongPairing {
        /// What the name is of: `tool`, `marker`, `CT`.
        what: &'static str,
        /// The name in the file.
        found: String,
        /// The name of what is in use.
        expected: String,
    },
}

impl FileError {
    pub(super) fn number(key: &'static str, found: &impl Debug, expected: impl Into<String>) -> Self {
        Self::BadNumber {
            key,
            found: quoted(&format!("{found:?}")),
            expected: expected.into(),
        }
    }
}
