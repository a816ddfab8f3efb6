//! Why a recording cannot be made, and what is lost by it.

use std::io;
use std::path::{Path, PathBuf};

use mcap::McapError;

use crate::write::pose_log::Unwritten;

/// Why a session cannot be recorded, or not any longer.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Somebody removed the file, or its folder, while it was written.
    #[error("{path} was removed while it was written: what it held is lost")]
    Removed {
        /// The file.
        path: PathBuf,
    },
    /// Somebody moved the file, or put another one in its place.
    #[error("{path} was moved or replaced while it was written: what it held is in no file of the session")]
    Moved {
        /// Where it was.
        path: PathBuf,
    },
    /// The file cannot be made.
    #[error(
        "creating {path}: {source}. The recording needs an existing folder that you may write to: \
         give another one with --out FILE.mcap"
    )]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Another recorder is at it.
    #[error("{path} is being written by another recorder. Stop that one, or give another file with --out FILE.mcap")]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// The file does not take any more.
    #[error(
        "writing {path}: {why}. {lost}. Make room on that disk, or record elsewhere with --out FILE.mcap; \
         `recorder recover {path}` makes what is there a whole file"
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
        /// Which messages are not on disk.
        lost: Lost,
    },
    /// The disk is as good as full.
    #[error(
        "recording to {path}: {free_mb:.0} MB are free on that disk, and at least {wanted_mb:.0} MB must be \
         (recording.min_free_mb). Make room there, or record elsewhere"
    )]
    NoRoom {
        /// The file.
        path: PathBuf,
        /// What is free, MB.
        free_mb: f64,
        /// What must be, MB.
        wanted_mb: f64,
    },
    /// The session ends while nothing is recorded.
    #[error(
        "the session was not recorded to its end: {unrecorded} messages are in no file. {why}. What was recorded before \
         is in the parts beside; `recorder recover` makes those that end in .recording whole"
    )]
    NotRecording {
        /// Why.
        why: String,
        /// Messages of the whole session.
        unrecorded: u64,
    },
    /// The disk did not keep what it was given.
    #[error("writing {path} to the disk: {why}. What was recorded since the last second may be lost")]
    Sync {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// A file, whole or not, cannot be given its name.
    #[error(
        "renaming {from} to {to}: {source}. The recording keeps its first name; `recorder verify` says whether it is whole"
    )]
    Rename {
        /// The file.
        from: PathBuf,
        /// Its name to be.
        to: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The scene cannot be read.
    #[error("reading {path}, to put it into the recording: {source}")]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// What a failed write loses, in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lost(pub Unwritten);

impl std::fmt::Display for Lost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Unwritten { messages, seqs } = self.0;
        match messages {
            0 => write!(f, "Every message taken so far is in the file"),
            n => write!(f, "Lost: the last {n} messages (numbers {} to {})", seqs.0, seqs.1),
        }
    }
}

/// mcap's error without its preamble.
pub(crate) fn words(error: &McapError) -> String {
    match error {
        McapError::Io(e) => e.to_string(),
        other => other.to_string(),
    }
}

pub(crate) fn write_error(path: &Path, error: &McapError, unwritten: Unwritten) -> FileError {
    FileError::Write {
        path: path.to_owned(),
        why: words(error),
        lost: Lost(unwritten),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_is_explained_with_what_is_lost() {
        let full = McapError::Io(io::ErrorKind::StorageFull.into());
        let unwritten = Unwritten {
            messages: 3,
            seqs: (7, 9),
        };
        let text = write_error("/d/s.mcap.recording".as_ref(), &full, unwritten).to_string();
        assert!(
            text.contains("no storage space. Lost: the last 3 messages (numbers 7 to 9)"),
            "{text}"
        );
        assert!(text.contains("Make room on that disk"), "{text}");
    }
}
