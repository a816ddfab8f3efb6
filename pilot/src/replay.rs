//! `pilot replay`: a recorded session in the place of the tracker.
//!
//! The scene is the recording's own. The recorder, as replayer, publishes the recorded poses with their stamps, and the
//! clock that they are old by; the renderers and everything behind them work as in any run. What the pilot must know
//! beforehand it asks the recorder for (`recorder facts`), as it reads no recordings itself.

mod args;
pub(crate) mod control;
mod facts;
mod prepare;
mod recompute;

use std::path::PathBuf;

use bus::clock;
use bus::run::ReplayOf;
use serde::Serialize;

pub(crate) use args::ReplayArgs;
pub(crate) use facts::{Facts, recorded_poses};
pub(crate) use prepare::{PrepareError, prepare};
pub(crate) use recompute::{Recompute, RecomputeError, Recomputed};

/// Pictures of the poses on the way, in the output folder.
const IMAGES: &str = "images";
/// Moments that a person had written as files, in the output folder.
const MOMENTS: &str = "moments";
/// The replayer's account of what it did, in the output folder.
pub(crate) const ACCOUNT: &str = "replay.json";

/// A recording to be replayed.
#[derive(Debug, Clone)]
pub(crate) struct Replay {
    pub(crate) recording: PathBuf,
    pub(crate) facts: Facts,
    /// As it was asked for: a number or `max`.
    pub(crate) speed: String,
    /// The first and the last moment, ns on the clock of the recorded run.
    pub(crate) span_ns: [i64; 2],
    pub(crate) looping: bool,
    pub(crate) force: bool,
    /// Pictures of every so many poses, beside those of the last one.
    pub(crate) every: Option<u64>,
    /// The poses are made again of what the localizer delivered, or the states of tissue of the poses.
    pub(crate) recompute: Option<Recompute>,
    /// Files that pictures are made of and of which the recording does not say whether they are its own, in words.
    pub(crate) unknown_files: Vec<String>,
}

impl Replay {
    /// What every process of the run must know.
    pub(crate) fn of(&self) -> ReplayOf {
        ReplayOf {
            recording: self.recording.clone(),
            volume_hash: self.facts.volume_hash.clone(),
            tissue_again: self.recompute.as_ref().is_some_and(|again| again.frames.is_none()),
        }
    }

    /// Seconds behind the recording's first pose.
    pub(crate) fn seconds(&self, moment_ns: i64) -> f64 {
        clock::ms(moment_ns.saturating_sub(self.facts.first_ns)) / 1e3
    }

    /// What the contact sheet must say of it, where it is not the sheet of the run that was recorded: `shown` is the examination
    /// that is.
    pub(crate) fn title(&self, shown: Option<&str>) -> Option<String> {
        let name = self.name();
        let why = match (&self.recompute, &self.facts.volume_hash) {
            (_, Some(recorded)) if shown != Some(recorded) => "recorded in ANOTHER EXAMINATION",
            (_, None) => "EXAMINATION NOT VERIFIED",
            (Some(Recompute { frames: None, .. }), _) => "tissue made again",
            (Some(_), _) => "poses made again",
            (None, _) => return None,
        };
        Some(format!("REPLAY of {name}, {why}"))
    }

    /// The recording's file name, for pictures and progress.
    pub(crate) fn name(&self) -> String {
        let name = self.recording.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// The replayer's arguments, without those that every process is given.
    pub(crate) fn arguments(&self, out: &std::path::Path, has_window: bool) -> Vec<String> {
        let out = std::path::absolute(out).unwrap_or_else(|_| out.to_owned());
        let path = |name: &str| out.join(name).to_string_lossy().into_owned();
        let [first, last] = self.span_ns.map(|ns| ns.to_string());
        let mut arguments = vec!["replay".to_owned(), self.recording.to_string_lossy().into_owned()];
        arguments.extend(["--span-ns".to_owned(), first, last]);
        arguments.extend(["--zero-ns".to_owned(), self.facts.first_ns.to_string()]);
        arguments.extend(["--speed".to_owned(), self.speed.clone()]);
        arguments.extend(["--account".to_owned(), path(ACCOUNT)]);
        arguments.extend(["--moments".to_owned(), path(MOMENTS)]);
        if let Some(every) = self.every {
            arguments.extend([
                "--images".to_owned(),
                path(IMAGES),
                "--every".to_owned(),
                every.to_string(),
            ]);
        }
        if let Some(frames) = self.recompute.as_ref().and_then(|recompute| recompute.frames) {
            arguments.extend(["--frames".to_owned(), frames.to_owned()]);
        }
        let flags = [
            (self.looping, "--loop"),
            (self.force, "--force"),
            // Poses that are made again are not those that the bar would tell of.
            (has_window && self.recompute.is_none(), "--timeline"),
        ];
        arguments.extend(flags.iter().filter(|(on, _)| *on).map(|(_, flag)| (*flag).to_owned()));
        arguments
    }
}

/// What the report says of a replay.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ReplayReport {
    pub(crate) recording: String,
    /// The run that was recorded.
    pub(crate) recorded_run: Option<String>,
    pub(crate) recorded_volume_hash: Option<String>,
    pub(crate) recorded_registration_id: Option<String>,
    /// Whether the examination shown is the one that was navigated in.
    pub(crate) same_volume: bool,
    pub(crate) speed: String,
    /// Seconds behind the recording's first pose.
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    /// What could not be read of the recording, and was replayed without.
    pub(crate) damage: Vec<String>,
    /// Where poses or states of tissue were made again: of what, and how far they lie from the recorded ones.
    pub(crate) recomputed: Option<Recomputed>,
}

impl ReplayReport {
    /// What was wrong, in words.
    pub(crate) fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        match &self.recorded_volume_hash {
            Some(_) if self.same_volume => {}
            Some(hash) => problems.push(format!(
                "the poses were recorded in another examination ({hash}): tube and anatomy do not belong together, and \
                 every image says so"
            )),
            None => problems.push(
                "the recording does not say in which examination it was made: nothing says that the one shown is it"
                    .to_owned(),
            ),
        }
        problems.extend(self.damage.iter().map(|damage| format!("the recording, {damage}")));
        problems.extend(self.recomputed.iter().flat_map(Recomputed::problems).cloned());
        problems
    }

    /// How far poses that were made again lie from the recorded ones, for people.
    pub(crate) fn recomputed(&self) -> Option<String> {
        self.recomputed.as_ref().map(|found| found.words.clone())
    }
}
