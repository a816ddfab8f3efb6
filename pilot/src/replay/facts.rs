//! What the recorder says of a recording.

use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::spawn;

/// What the recorder says of a recording. It may say more one day.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Facts {
    pub(crate) scene: Option<String>,
    pub(crate) run: Option<String>,
    pub(crate) volume_hash: Option<String>,
    pub(crate) registration_id: Option<String>,
    pub(crate) poses: u64,
    /// When the first pose was published, ns on the recorded run's clock.
    pub(crate) first_ns: i64,
    pub(crate) last_ns: i64,
    pub(crate) emitters: u64,
    /// Why no poses can be made of them, in words.
    pub(crate) emitters_refused: Option<String>,
    pub(crate) markers: u64,
    pub(crate) markers_refused: Option<String>,
    /// Calibrations and registrations that the recording holds.
    pub(crate) files: Vec<AttachedText>,
    /// What cannot be read, in words.
    pub(crate) damage: Vec<String>,
}

/// A text file that a recording holds.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct AttachedText {
    pub(crate) name: String,
    pub(crate) text: String,
}

/// Why nothing is known of a recording.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FactsError {
    #[error("asking {program} about {recording}: {source}. Every program of Trocar lies in one folder")]
    Ask {
        program: PathBuf,
        recording: PathBuf,
        source: io::Error,
    },
    #[error("{0} cannot be replayed, for the reason given above")]
    Refused(PathBuf),
    #[error("the recorder's answer about {recording} is not what this version understands: {source}")]
    Answer {
        recording: PathBuf,
        source: serde_json::Error,
    },
}

/// How many poses a recording holds by its index; 0 for one that holds none, or cannot be read.
pub(crate) fn recorded_poses(recording: &Path) -> u64 {
    // A recorder that was killed before the first pose leaves a file without any, which is no fault to be told of.
    let answer = spawn::ask_quietly("recorder", &["facts".as_ref(), recording.as_os_str()]);
    let Some(output) = answer.ok().filter(|output| output.status.success()) else {
        return 0;
    };
    serde_json::from_slice::<Facts>(&output.stdout).map_or(0, |facts| facts.poses)
}

/// Asks the recorder, who goes by the file's index unless all of it is to be read; its own words, if it refuses, stand on stderr.
pub(crate) fn ask(recording: &Path, whole: bool) -> Result<Facts, FactsError> {
    let mut arguments = vec!["facts".as_ref(), recording.as_os_str()];
    if whole {
        arguments.push("--whole".as_ref());
    }
    let output = spawn::ask("recorder", &arguments);
    let (program, output) = output;
    let output = output.map_err(|source| FactsError::Ask {
        program,
        recording: recording.to_owned(),
        source,
    })?;
    if !output.status.success() {
        return Err(FactsError::Refused(recording.to_owned()));
    }
    serde_json::from_slice(&output.stdout).map_err(|source| FactsError::Answer {
        recording: recording.to_owned(),
        source,
    })
}
