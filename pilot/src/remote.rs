//! `pilot remote`: the run of another machine, shown here.
//!
//! `remote-proc receive` stands in the place of the loader and of the tracker: it publishes the examination, the poses, and the clock
//! that they are old by. The scene is the other machine's own. What the pilot must know beforehand it asks for (`remote-proc facts`), as
//! it knows no networks itself. What is chosen and confirmed is so on the other machine, and nothing goes back to it.

mod facts;

use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::run::RemoteOf;
use scene::raw::{self, Source};
use scene::{Scene, SceneError};
use serde::Serialize;

use crate::cli::duration;
use crate::state::Options;
pub(crate) use facts::{RemoteFacts, RemoteFactsError};

/// Why another machine's run is not shown.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RemoteError {
    #[error(transparent)]
    Facts(#[from] RemoteFactsError),
    #[error("the scene of run {run:?} at {endpoint} is none that this version understands: {source}")]
    Scene {
        run: String,
        endpoint: String,
        source: SceneError,
    },
}

#[derive(Debug, clap::Args)]
pub(crate) struct RemoteArgs {
    /// Where `remote-proc send` listens: tls/HOST:PORT, or tcp/127.0.0.1:PORT on this machine.
    #[arg(value_name = "ENDPOINT")]
    pub(crate) endpoint: String,
    /// The folder with this side's keys, as `remote-proc keys` made them: authority.pem, receiver.pem, receiver.key.
    #[arg(long, value_name = "DIR")]
    pub(crate) keys: Option<PathBuf>,
    /// How long to show it (500ms, 10s, 2m); without it, until stopped.
    #[arg(long = "for", value_name = "TIME", value_parser = duration::parse)]
    pub(crate) duration: Option<Duration>,
    /// Records here too, as the other machine's scene says. What is recorded is a patient's: without this, nothing is.
    #[arg(long)]
    pub(crate) record: bool,
    /// Where pictures and report go.
    #[arg(long, default_value = "remote")]
    pub(crate) out: PathBuf,
    /// Replace a session that is already in the output folder.
    #[arg(long)]
    pub(crate) overwrite: bool,
    /// Opens the window on the display that DISPLAY names.
    #[arg(long)]
    pub(crate) window: bool,
    /// No window, whatever else is said.
    #[arg(long)]
    pub(crate) headless: bool,
    /// Names the run here; runs of different names do not see each other.
    #[arg(long, default_value = "remote")]
    pub(crate) run: String,
}

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

/// Asks the other machine, and refuses what cannot be shown before anything is started.
pub(crate) fn prepare(args: &RemoteArgs) -> Result<(Options, Source, Scene), RemoteError> {
    let keys = args.keys.as_deref().map(absolute);
    let facts = facts::ask(&args.endpoint, keys.as_deref())?;
    let bad = |source| RemoteError::Scene {
        run: facts.run.clone(),
        endpoint: args.endpoint.clone(),
        source,
    };
    let (source, scene) = scene(&facts, args.record).map_err(bad)?;
    let options = Options {
        run: args.run.clone(),
        out: args.out.clone(),
        overwrite: args.overwrite,
        duration: args.duration,
        simulated_time: false,
        has_window: args.window && !args.headless,
        replay: None,
        remote: Some(Remote {
            endpoint: args.endpoint.clone(),
            keys,
            facts,
        }),
        planning: None,
    };
    Ok((options, source, scene))
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// The other machine's scene without what that machine alone does or has: it serves other programs, guides calibrations, and its files
/// of structures lie there. The tracker's part stays, as it says how poses are to be judged; nothing of it is started.
fn scene(facts: &RemoteFacts, record: bool) -> Result<(Source, Scene), SceneError> {
    let mut source = raw::parse(&facts.scene, Path::new("scene.toml"))?;
    let scene = &mut source.scene;
    (scene.gateway, scene.steps, scene.pacs) = (None, None, None);
    if let Some(plan) = scene.plan.as_mut() {
        plan.labels = None;
    }
    if !record {
        scene.recording = None;
    }
    let checked = Scene::from_raw(&source)?;
    Ok((source, checked))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts(scene: &str) -> RemoteFacts {
        RemoteFacts {
            run: "or-3".to_owned(),
            scene: scene.to_owned(),
            volume_hash: "ab".to_owned(),
            session: "17".to_owned(),
            now_ns: 5_000_000_000,
            monotonic_ns: 2_000_000_000,
        }
    }

    #[test]
    fn the_other_scene_is_shown_without_what_its_machine_alone_does() {
        let text = "[gateway]\n[recording]\n[tracker]\nsource = \"markers\"\n[localizer]\nkind = \"openigtlink\"\n\
                    address = \"127.0.0.1:18944\"\n[limits]\nstale_ms = 77";
        let (_, shown) = scene(&facts(text), false).unwrap();
        assert!(shown.gateway.is_none() && shown.recording.is_none());
        assert_eq!(shown.limits.stale, Duration::from_millis(77));
        let (_, recorded) = scene(&facts(text), true).unwrap();
        assert!(recorded.recording.is_some());
        assert!(scene(&facts("[nonsense]"), false).is_err());
    }

    #[test]
    fn the_clock_here_begins_where_the_other_ones_stands() {
        let remote = Remote {
            endpoint: "tcp/127.0.0.1:7447".to_owned(),
            keys: None,
            facts: facts(""),
        };
        assert_eq!(remote.epoch_ns(), -3_000_000_000);
        assert_eq!(remote.arguments(), ["receive", "tcp/127.0.0.1:7447", "--session", "17"]);
    }
}
