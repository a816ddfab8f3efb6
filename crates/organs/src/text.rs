//! The text of a scene file: read within a bound, parsed with the places of its keys.

use std::io::Read;
use std::path::{Path, PathBuf};

use scene::{Invalid, SceneError, locate};
use serde::de::DeserializeOwned;

/// A scene with every node of its meshes written out is no longer than this, bytes.
const MAX_BYTES: u64 = 4 << 20;

/// A raw scene with the text it came from, for errors that point at a line.
#[derive(Debug, Clone)]
pub struct Parsed<S> {
    /// The file, for errors.
    pub path: PathBuf,
    text: String,
    /// What it says, with nothing but types checked.
    pub scene: S,
}

/// The text of a scene file.
///
/// # Errors
/// [`SceneError`], but not its `Value`.
pub fn read(path: &Path) -> Result<String, SceneError> {
    let io = |source| SceneError::Io {
        path: path.to_owned(),
        source,
    };
    // One byte more than is allowed tells that there is more, whatever the file's own length says.
    let mut bytes = Vec::new();
    let (file, about) = scene::file::open(path).map_err(|error| io(error.into()))?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(SceneError::TooLong {
            path: path.to_owned(),
            bytes: about.len().max(MAX_BYTES + 1),
            allowed: MAX_BYTES,
        });
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at].iter().filter(|b| **b == b'\n').count();
        SceneError::Syntax {
            path: path.to_owned(),
            line,
            column: 1,
            key: None,
            why: format!("byte {at} of the file is not UTF-8"),
        }
    })
}

impl<S: DeserializeOwned> Parsed<S> {
    /// Reads the text of a scene.
    ///
    /// # Errors
    /// [`SceneError::Syntax`].
    pub fn parse(text: String, path: &Path) -> Result<Self, SceneError> {
        let scene: S = toml::from_str(&text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let (line, column) = locate::line_and_column(&text, at);
            SceneError::Syntax {
                path: path.to_owned(),
                line,
                column,
                key: locate::key_at(&text, at),
                why: error.message().to_owned(),
            }
        })?;
        Ok(Self {
            path: path.to_owned(),
            text,
            scene,
        })
    }
}

impl<S> Parsed<S> {
    /// The error with the place of its key.
    pub fn error_at(&self, invalid: Invalid) -> SceneError {
        let at = locate::position_of(&self.text, &invalid.key).unwrap_or(0);
        let (line, column) = locate::line_and_column(&self.text, at);
        SceneError::Value {
            path: self.path.clone(),
            line,
            column,
            invalid,
        }
    }
}
