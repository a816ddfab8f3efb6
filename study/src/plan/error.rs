//! Why a study cannot be.

use std::path::PathBuf;

/// Why a study cannot be.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A file that cannot be read.
    #[error("study file {path}: {why}")]
    Open {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// A file that is no TOML, or has an unknown key or a value of another kind: the words have line and column.
    #[error("study file {path}: {why}")]
    Grammar {
        /// The file.
        path: PathBuf,
        /// Where and why.
        why: String,
    },
    /// A value that cannot be.
    #[error("study file {path}, {place}: found {found}; {expected}")]
    Value {
        /// The file.
        path: PathBuf,
        /// The stratum and the key.
        place: String,
        /// What stands there.
        found: String,
        /// What may stand there, or what is wrong.
        expected: String,
    },
    /// Two strata of one name.
    #[error("study file {path}: a second stratum {name:?}; lines of operations.csv are told apart by that name")]
    Twice {
        /// The file of the second.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// No stratum at all.
    #[error("no stratum to study: give a file with a table [[stratum]]")]
    Nothing,
}
