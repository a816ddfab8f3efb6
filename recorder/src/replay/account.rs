//! What came of a replay, as JSON for scripts.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::timing::Lateness;

/// What came of a replay. Keys are only ever added.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Account {
    /// The recording.
    pub recording: String,
    /// The speed that was asked for last.
    pub speed: String,
    /// playing, paused, ended
    pub state: &'static str,
    /// The first moment, seconds behind the recording's first pose.
    pub from_s: f64,
    /// The last one.
    pub to_s: f64,
    /// Poses published.
    pub published: u64,
    /// Poses whose frame of the localizer is not in the recording, where poses are made again: they are not.
    pub without_frames: u64,
    /// Poses of which the recording has no state of the tissue, where states are made again: they are left out.
    pub without_state: u64,
    /// Frames of which the tracker made no pose in time.
    pub unanswered: u64,
    /// What could not be read of the recording, and was left out, in words.
    pub unread: Vec<String>,
    /// How long it took, s of the machine's clock.
    pub wall_s: f64,
    /// How well time was kept by those poses that went out by the clock.
    pub lateness: Lateness,
    /// Pictures written.
    pub images: u64,
    /// Poses of one renderer that had nothing to picture.
    pub images_missing: u64,
    /// Why, of the last one.
    pub images_reason: String,
}

/// Why the account was not written.
#[derive(Debug, thiserror::Error)]
#[error("writing {path}: {source}")]
pub struct AccountError {
    path: PathBuf,
    source: io::Error,
}

impl Account {
    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// [`AccountError`].
    pub fn write(&self, path: &Path) -> Result<(), AccountError> {
        let part = path.with_extension("json.part");
        let text = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        let written = fs::write(&part, text).and_then(|()| fs::rename(&part, path));
        written.map_err(|source| AccountError {
            path: path.to_owned(),
            source,
        })
    }
}
