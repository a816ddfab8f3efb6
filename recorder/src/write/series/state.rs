//! Whether a session is being written.

use std::path::Path;

use super::place::Place;
use crate::write::paths;
use crate::write::session_file::SessionFile;

#[derive(Debug)]
pub(super) enum State {
    Writing {
        file: Box<SessionFile>,
        place: Place,
        since_ns: i64,
        flush_at_ns: Option<i64>,
    },
    Stopped {
        why: String,
        unrecorded: u64,
        again_ns: i64,
    },
}

impl State {
    /// Why nothing is written, without the names of `folder`.
    pub(super) fn why(&self, folder: Option<&Path>) -> Option<String> {
        let folder = folder.map_or(String::new(), |folder| format!("{}/", folder.display()));
        match self {
            Self::Writing { .. } => None,
            Self::Stopped { why, .. } if folder.len() > 1 => Some(why.replace(&folder, "")),
            Self::Stopped { why, .. } => Some(why.clone()),
        }
    }
}

/// Writing `file`, the growing one of `out`.
pub(super) fn writing(file: SessionFile, out: &Path, since_ns: i64) -> State {
    State::Writing {
        place: Place::of(file.file(), paths::recording(out)),
        file: Box::new(file),
        since_ns,
        flush_at_ns: None,
    }
}

/// Stopped for no cause that was told, with that many messages in no file.
pub(super) fn stopped(again_ns: i64, unrecorded: u64) -> State {
    State::Stopped {
        why: String::new(),
        unrecorded,
        again_ns,
    }
}
