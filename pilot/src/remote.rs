//! `pilot remote`: the run of another machine, shown here.
//!
//! `remote-proc receive` stands in the place of the loader and of the tracker: it publishes the examination, the poses, and the clock
//! that they are old by. The scene is the other machine's own. What the pilot must know beforehand it asks for (`remote-proc facts`), as
//! it knows no networks itself. What is chosen and confirmed is so on the other machine, and nothing goes back to it.

mod facts;
mod prepare;

use std::path::PathBuf;

use bus::run::RemoteOf;
use serde::Serialize;

pub(crate) use facts::RemoteFacts;
pub(crate) use prepare::{RemoteArgs, RemoteError, prepare};

/// Another machine's run.
#[derive(Debug, Clone)]
pub(crate) struct Remote {
    pub(crate) endpoint: String,
    pub(crate) keys: Option<PathBuf>,
    pub(crate) facts: RemoteFacts,
}

impl Remote {
    /// What every process of the run must know.
    pub(crate) fn of(&self) -> RemoteOf {
        RemoteOf {
            endpoint: self.endpoint.clone(),
            run: self.facts.run.clone(),
        }
    }

    /// The zero of this run's clock on this machine's CLOCK_MONOTONIC, so that it shows about what the other's does: stamps of both can
    /// then stand in one recording. How old a pose is goes by the session's clock, which is known to a fraction of a millisecond.
    pub(crate) fn epoch_ns(&self) -> i64 {
        self.facts.monotonic_ns.saturating_sub(self.facts.now_ns)
    }

    /// The receiver's arguments, without those that every process is given.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let mut arguments = vec!["receive".to_owned(), self.endpoint.clone()];
        let keys = self.keys.as_ref().map(|keys| keys.to_string_lossy().into_owned());
        arguments.extend(keys.into_iter().flat_map(|keys| ["--keys".to_owned(), keys]));
        arguments.extend(["--session".to_owned(), self.facts.session.clone()]);
        arguments
    }

    /// What the report says of it.
    pub(crate) fn report(&self, shown: Option<&str>) -> RemoteReport {
        RemoteReport {
            endpoint: self.endpoint.clone(),
            run: self.facts.run.clone(),
            volume_hash: self.facts.volume_hash.clone(),
            same_volume: shown == Some(&self.facts.volume_hash),
        }
    }
}

/// What the report says of another machine's run.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct RemoteReport {
    endpoint: String,
    /// Its name there.
    run: String,
    /// The examination there.
    volume_hash: String,
    /// Whether what was shown here is that examination.
    same_volume: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_here_begins_where_the_other_ones_stands() {
        let remote = Remote {
            endpoint: "tcp/127.0.0.1:7447".to_owned(),
            keys: None,
            facts: RemoteFacts::sample(""),
        };
        assert_eq!(remote.epoch_ns(), -3_000_000_000);
        assert_eq!(remote.arguments(), ["receive", "tcp/127.0.0.1:7447", "--session", "17"]);
    }
}
