//! Errors that point at a line of a scene file.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("reading scene {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is far too long for a scene.
    #[error("reading scene {path}: {bytes} bytes; at most {allowed} are allowed")]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// The most allowed.
        allowed: u64,
    },
    /// Not TOML, an unknown key, or a value of a wrong type.
    #[error("scene {path}, line {line}, column {column}{}: {why}", key_part(.key))]
    Syntax {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The key, dotted, where there is one.
        key: Option<String>,
        /// What is wrong, with what was found and what is allowed.
        why: String,
    },
    /// A value that cannot be used.
    #[error("scene {path}, line {line}, column {column}, {invalid}")]
    Value {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// Key, found, allowed.
        invalid: Invalid,
    },
}

fn key_part(key: &Option<String>) -> String {
    key.as_ref().map(|key| format!(", key {key}")).unwrap_or_default()
}

/// A value that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Invalid {
    /// The key, dotted, elements of lists by index: `views.1.name`.
    pub key: String,
    /// What the file says.
    pub found: String,
    /// What it may say.
    pub allowed: String,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, found, allowed } = self;
        write!(f, "key {key}: found {found}; allowed: {allowed}")
    }
}
