//! How a session is recorded: `[recording]`.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::values::{Checked, number, seconds};

/// How the chunks of a recording are compressed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// Smallest.
    #[default]
    Zstd,
    /// Fastest of those that compress.
    Lz4,
    /// As it is.
    None,
}

/// `[recording]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawRecording {
    /// A chunk is closed after this time.
    pub chunk_s: f64,
    /// How chunks are compressed.
    pub compression: Compression,
    /// The disk is told to keep what it was given after this time.
    pub sync_s: f64,
    /// A file that has grown beyond this is completed, and the next one started; 0: never.
    pub rotate_mb: f64,
    /// A file is completed after this time, and the next one started; 0: never.
    pub rotate_min: f64,
    /// Recording stops where the disk has less left, and goes on once it has more again.
    pub min_free_mb: f64,
    /// Small images of each view a second; 0: none.
    pub thumbnails_per_s: f64,
    /// Whether it says whose examination it is.
    pub identity: bool,
}

impl Default for RawRecording {
    fn default() -> Self {
        Self {
            chunk_s: 0.5,
            compression: Compression::Zstd,
            sync_s: 0.5,
            rotate_mb: 0.0,
            rotate_min: 0.0,
            min_free_mb: 200.0,
            thumbnails_per_s: 0.0,
            identity: false,
        }
    }
}

/// How the session is recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSpec {
    /// A chunk is closed after this time: what a crash can lose.
    pub chunk: Duration,
    /// How chunks are compressed.
    pub compression: Compression,
    /// At most this often the disk is told to keep what it was given: what a power cut can lose on top of a chunk.
    pub sync: Duration,
    /// A file that has grown beyond this, bytes, is completed, and the next one started.
    pub rotate_bytes: Option<u64>,
    /// A file is completed after this time, and the next one started.
    pub rotate_after: Option<Duration>,
    /// Recording stops where the disk has less left, bytes.
    pub min_free_bytes: u64,
    /// Between two small images of a view; `None`: there are none.
    pub thumbnail_every: Option<Duration>,
    /// Whether it says whose examination it is; else nothing in it does.
    pub identity: bool,
}

impl Default for RecordingSpec {
    /// That of a scene whose `[recording]` is empty.
    fn default() -> Self {
        Self {
            chunk: Duration::from_millis(500),
            compression: Compression::Zstd,
            sync: Duration::from_millis(500),
            rotate_bytes: None,
            rotate_after: None,
            min_free_bytes: 200 * MB as u64,
            thumbnail_every: None,
            identity: false,
        }
    }
}

const MB: f64 = 1e6;

pub(super) fn checked(raw: Option<&RawRecording>) -> Checked<Option<RecordingSpec>> {
    raw.map(spec).transpose()
}

fn spec(raw: &RawRecording) -> Checked<RecordingSpec> {
    let rotate_mb = number_or_zero("recording.rotate_mb", raw.rotate_mb, [1.0, 1e6], "MB")?;
    let rotate_min = number_or_zero("recording.rotate_min", raw.rotate_min, [0.01, 1440.0], "min")?;
    let thumbnails = number_or_zero("recording.thumbnails_per_s", raw.thumbnails_per_s, [0.01, 10.0], "1/s")?;
    let min_free_mb = number("recording.min_free_mb", raw.min_free_mb, 1.0..=1e6, "MB")?;
    Ok(RecordingSpec {
        chunk: seconds("recording.chunk_s", raw.chunk_s, 0.05..=1.0)?,
        compression: raw.compression,
        sync: seconds("recording.sync_s", raw.sync_s, 0.1..=60.0)?,
        rotate_bytes: rotate_mb.map(|mb| (mb * MB) as u64),
        rotate_after: rotate_min.map(|min| Duration::from_secs_f64(60.0 * min)),
        min_free_bytes: (min_free_mb * MB) as u64,
        thumbnail_every: thumbnails.map(|per_s| Duration::from_secs_f64(1.0 / per_s)),
        identity: raw.identity,
    })
}

/// A number within `[low, high]`, or `None` for 0.
fn number_or_zero(key: &str, value: f64, [low, high]: [f64; 2], unit: &str) -> Checked<Option<f64>> {
    if value == 0.0 {
        return Ok(None);
    }
    let checked = number(key, value, low..=high, unit);
    checked.map(Some).map_err(|mut invalid| {
        invalid.allowed = format!("0 for never, or {}", invalid.allowed);
        invalid
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use std::path::Path;

    fn parsed(keys: &str) -> Result<RecordingSpec, String> {
        let scene = Scene::parse(&format!("[recording]\n{keys}"), Path::new("s.toml"));
        scene.map(|scene| scene.recording.unwrap()).map_err(|e| e.to_string())
    }

    #[test]
    fn an_empty_table_is_the_default() {
        assert_eq!(parsed("").unwrap(), RecordingSpec::default());
    }

    #[test]
    fn every_key_is_taken() {
        let text = "compression = \"lz4\"\nsync_s = 2.0\nrotate_mb = 500.0\nrotate_min = 10.0\nmin_free_mb = 50.0\n\
                    thumbnails_per_s = 0.5\nchunk_s = 0.25\nidentity = true";
        let expected = RecordingSpec {
            chunk: Duration::from_millis(250),
            compression: Compression::Lz4,
            sync: Duration::from_secs(2),
            rotate_bytes: Some(500_000_000),
            rotate_after: Some(Duration::from_secs(600)),
            min_free_bytes: 50_000_000,
            thumbnail_every: Some(Duration::from_secs(2)),
            identity: true,
        };
        assert_eq!(parsed(text).unwrap(), expected);
        assert_eq!(parsed("compression = \"none\"").unwrap().compression, Compression::None);
    }

    #[test]
    fn impossible_values_are_refused_with_what_is_allowed() {
        for (key, words) in [
            ("rotate_mb = 0.5", "found 0.5; allowed: 0 for never, or 1 to 1000000 MB"),
            (
                "rotate_min = -1.0",
                "found -1; allowed: 0 for never, or 0.01 to 1440 min",
            ),
            (
                "thumbnails_per_s = 60.0",
                "found 60; allowed: 0 for never, or 0.01 to 10 1/s",
            ),
            ("min_free_mb = nan", "found NaN; allowed: 1 to 1000000 MB"),
            ("sync_s = 0.0", "found 0; allowed: 0.1 to 60 s"),
            ("compression = \"zip\"", "zip"),
        ] {
            let error = parsed(key).unwrap_err();
            assert!(error.contains(words) && error.contains("line 2"), "{key}: {error}");
        }
    }
}
