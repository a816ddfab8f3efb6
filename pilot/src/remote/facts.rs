//! What another machine says of its run.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::spawn;

/// What another machine says of its run. It may say more one day.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub(crate) struct RemoteFacts {
    /// Its name.
    pub(crate) run: String,
    /// The text of its scene.
    pub(crate) scene: String,
    pub(crate) volume_hash: String,
    /// Tells this sender from one that comes after it.
    pub(crate) session: String,
    /// What its clock showed, about, when CLOCK_MONOTONIC showed `monotonic_ns` here; ns.
    pub(crate) now_ns: i64,
    pub(crate) monotonic_ns: i64,
}

/// Why nothing is known of it.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RemoteFactsError {
    #[error(
        "there is no {0}: the program for a second machine is built by itself, with `cargo xtask remote` (docs/remote.md)"
    )]
    NotBuilt(PathBuf),
    #[error("starting {program}: {source}")]
    Ask { program: PathBuf, source: io::Error },
    #[error("{0} cannot be shown, for the reason given above")]
    Refused(String),
    #[error("remote-proc's answer about {endpoint} is not what this version understands: {source}")]
    Answer {
        endpoint: String,
        source: serde_json::Error,
    },
}

/// Asks `remote-proc`; its own words, if it refuses, stand on stderr.
pub(crate) fn ask(endpoint: &str, keys: Option<&Path>) -> Result<RemoteFacts, RemoteFactsError> {
    let mut arguments: Vec<&OsStr> = vec!["facts".as_ref(), endpoint.as_ref()];
    if let Some(keys) = keys {
        arguments.extend::<[&OsStr; 2]>(["--keys".as_ref(), keys.as_os_str()]);
    }
    let (program, output) = spawn::ask("remote-proc", &arguments);
    let output = output.map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => RemoteFactsError::NotBuilt(program),
        _ => RemoteFactsError::Ask { program, source },
    })?;
    if !output.status.success() {
        return Err(RemoteFactsError::Refused(endpoint.to_owned()));
    }
    serde_json::from_slice(&output.stdout).map_err(|source| RemoteFactsError::Answer {
        endpoint: endpoint.to_owned(),
        source,
    })
}

#[cfg(test)]
impl RemoteFacts {
    /// Of a run whose clock is 3 s ahead of this machine's.
    pub(super) fn sample(scene: &str) -> Self {
        Self {
            run: "or-3".to_owned(),
            scene: scene.to_owned(),
            volume_hash: "ab".to_owned(),
            session: "17".to_owned(),
            now_ns: 5_000_000_000,
            monotonic_ns: 2_000_000_000,
        }
    }
}
