//! From what the user asked for to a run in which another machine's is shown.

use std::path::{Path, PathBuf};
use std::time::Duration;

use scene::raw::{self, Source};
use scene::{Scene, SceneError};

use super::Remote;
use super::facts::{self, RemoteFacts, RemoteFactsError};
use crate::cli::duration;
use crate::state::Options;

/// Why another machine's run is not shown.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RemoteError {
    #[error(transparent)]
    Facts(#[from] RemoteFactsError),
    #[error("the scene of run {run:?} at {endpoint} is none that this version understands: {source}")]
    Scene {
        run: String,
        endpoint: String,
        source: Box<SceneError>,
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
    /// Records here, as the other machine's scene says, if it says anything. What is recorded is a patient's: without this, nothing is.
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

/// Asks the other machine, and refuses what cannot be shown before anything is started.
pub(crate) fn prepare(args: &RemoteArgs) -> Result<(Options, Source, Scene), RemoteError> {
    let keys = args.keys.as_deref().map(absolute);
    let facts = facts::ask(&args.endpoint, keys.as_deref())?;
    let bad = |source| RemoteError::Scene {
        run: facts.run.clone(),
        endpoint: args.endpoint.clone(),
        source: Box::new(source),
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
/// of structures lie there. The tracker's part stays, as it says how poses are to be judged; nothing of it is started. So does the tissue's: its states
/// come over the link, and an image without one must say so.
fn scene(facts: &RemoteFacts, record: bool) -> Result<(Source, Scene), SceneError> {
    let mut source = raw::parse(&facts.scene, Path::new("scene.toml"))?;
    let scene = &mut source.scene;
    (scene.gateway, scene.steps, scene.pacs) = (None, None, None);
    if let Some(plan) = scene.plan.as_mut() {
        plan.labels = None;
    }
    match record {
        // Who asks for a recording has one, whether the other machine makes one or not.
        true => drop(scene.recording.get_or_insert_default()),
        false => scene.recording = None,
    }
    let checked = Scene::from_raw(&source)?;
    Ok((source, checked))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_scene_is_shown_without_what_its_machine_alone_does() {
        let text = "[gateway]\n[recording]\n[tracker]\nsource = \"markers\"\n[localizer]\nkind = \"openigtlink\"\n\
                    address = \"127.0.0.1:18944\"\n[tissue]\norgans = \"kidney.toml\"\nlate_ms = 30\n[limits]\nstale_ms = 77";
        let (_, shown) = scene(&RemoteFacts::sample(text), false).unwrap();
        assert!(shown.gateway.is_none() && shown.recording.is_none());
        // Renderers take states, and tell that there is none, only in a scene whose organs move.
        assert!(shown.tissue.is_some());
        assert_eq!(shown.limits.stale, Duration::from_millis(77));
        let (_, recorded) = scene(&RemoteFacts::sample(text), true).unwrap();
        assert!(recorded.recording.is_some());
        let (_, asked_for) = scene(&RemoteFacts::sample(""), true).unwrap();
        assert!(asked_for.recording.is_some());
        assert!(scene(&RemoteFacts::sample("[nonsense]"), false).is_err());
    }
}
