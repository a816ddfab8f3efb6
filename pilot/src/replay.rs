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
use bus::message::ReplayState;
use bus::run::ReplayOf;
use serde::{Deserialize, Serialize};

use crate::state::{Options, Run};

pub(crate) use args::ReplayArgs;
pub(crate) use facts::{Facts, recorded_poses};
pub(crate) use prepare::{PrepareError, prepare};
pub(crate) use recompute::{Recompute, RecomputeError, Recomputed};

/// The name of the replayer's process.
pub(crate) const REPLAYER: &str = "replay";
/// Pictures of the poses on the way, in the output folder.
const IMAGES: &str = "images";
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
    /// The poses are made again of the recorded emitters.
    pub(crate) recompute: Option<Recompute>,
}

impl Replay {
    /// What every process of the run must know.
    pub(crate) fn of(&self) -> ReplayOf {
        ReplayOf {
            recording: self.recording.clone(),
            volume_hash: self.facts.volume_hash.clone(),
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
    pub(crate) fn arguments(&self, out: &std::path::Path) -> Vec<String> {
        let out = std::path::absolute(out).unwrap_or_else(|_| out.to_owned());
        let path = |name: &str| out.join(name).to_string_lossy().into_owned();
        let [first, last] = self.span_ns.map(|ns| ns.to_string());
        let mut arguments = vec!["replay".to_owned(), self.recording.to_string_lossy().into_owned()];
        arguments.extend(["--span-ns".to_owned(), first, last]);
        arguments.extend(["--zero-ns".to_owned(), self.facts.first_ns.to_string()]);
        arguments.extend(["--speed".to_owned(), self.speed.clone()]);
        arguments.extend(["--account".to_owned(), path(ACCOUNT)]);
        if let Some(every) = self.every {
            arguments.extend([
                "--images".to_owned(),
                path(IMAGES),
                "--every".to_owned(),
                every.to_string(),
            ]);
        }
        let flags = [
            (self.looping, "--loop"),
            (self.force, "--force"),
            (self.recompute.is_some(), "--emitters"),
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
    /// Where poses were made again: of what, and how far they lie from the recorded ones.
    pub(crate) recomputed: Option<Recomputed>,
}

/// What the replayer could not read on its way.
fn unread(out: &std::path::Path) -> Vec<String> {
    let account = std::fs::read(out.join(ACCOUNT)).unwrap_or_default();
    let account: serde_json::Value = serde_json::from_slice(&account).unwrap_or_default();
    let list = account["unread"].as_array().cloned().unwrap_or_default();
    list.iter()
        .filter_map(|words| words.as_str().map(str::to_owned))
        .collect()
}

impl ReplayReport {
    /// The report on `run`, where it is a replay.
    pub(crate) fn of(run: &Run) -> Option<Self> {
        let replay = run.options.replay.as_ref()?;
        let shown = run.books.volume_hash().map(|hash| hash.to_string());
        Some(Self {
            recording: replay.recording.display().to_string(),
            recorded_run: replay.facts.run.clone(),
            recorded_registration_id: replay.facts.registration_id.clone(),
            same_volume: shown.is_some() && shown == replay.facts.volume_hash,
            recorded_volume_hash: replay.facts.volume_hash.clone(),
            speed: replay.speed.clone(),
            from_s: replay.seconds(replay.span_ns[0]),
            to_s: replay.seconds(replay.span_ns[1]),
            damage: match replay.facts.damage.is_empty() {
                true => unread(&run.options.out),
                false => replay.facts.damage.clone(),
            },
            recomputed: run.recomputed.clone(),
        })
    }

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

/// Where a replay stands, for `pilot status`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ReplayStatus {
    pub(crate) recording: String,
    /// playing, paused, ended
    pub(crate) state: String,
    /// A number, or `max`.
    pub(crate) speed: String,
    /// Seconds behind the recording's first pose.
    pub(crate) at_s: f64,
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
}

impl ReplayStatus {
    /// Where `run` stands, if it is a replay.
    pub(crate) fn of(run: &Run) -> Option<Self> {
        let replay = run.options.replay.as_ref()?;
        let told = run.session.replay();
        let speed = told.map_or(f64::NAN, |law| law.speed);
        Some(Self {
            recording: replay.recording.display().to_string(),
            state: told.map_or("waiting", |law| law.replay_state().word()).to_owned(),
            speed: match speed {
                speed if speed.is_infinite() => "max".to_owned(),
                speed if speed.is_nan() => replay.speed.clone(),
                speed => speed.to_string(),
            },
            at_s: told.map_or(0.0, |_| replay.seconds(run.session.clock().now_ns())),
            from_s: replay.seconds(replay.span_ns[0]),
            to_s: replay.seconds(replay.span_ns[1]),
        })
    }

    /// One line for people.
    pub(crate) fn line(&self) -> String {
        format!(
            "REPLAY of {}: {}, speed {}, at {:.2} s of {:.2} s to {:.2} s",
            self.recording, self.state, self.speed, self.at_s, self.from_s, self.to_s
        )
    }
}

impl Options {
    /// How the run ends, in words.
    pub(crate) fn ending(&self) -> String {
        match (&self.replay, self.duration) {
            (Some(replay), _) => {
                let [from, to] = replay.span_ns.map(|ns| replay.seconds(ns));
                let made = replay.recompute.as_ref().map_or("", |_| ", poses made again");
                let again = if replay.looping { ", again and again" } else { "" };
                let (name, speed) = (replay.name(), &replay.speed);
                format!("replaying {name} from {from:.2} s to {to:.2} s at speed {speed}{again}{made}")
            }
            (None, Some(duration)) if self.simulated_time => {
                let s = duration.as_secs_f64();
                format!("navigating for {s:.1} s of simulated time, as fast as every view draws every pose")
            }
            (None, Some(duration)) => format!("navigating for {:.1} s", duration.as_secs_f64()),
            (None, None) => format!("navigating until `pilot stop --run {}` or Ctrl-C", self.run),
        }
    }
}

impl Run {
    /// Whether the last pose of a replay, or of a run in simulated time, has gone out.
    pub(crate) fn replay_has_ended(&self) -> bool {
        self.session
            .replay()
            .is_some_and(|law| law.replay_state() == ReplayState::Ended)
    }

    /// Whether a replay, or a run in simulated time, waits for a process that will not come back.
    pub(crate) fn replay_is_stuck(&self) -> bool {
        self.session.is_ruled() && self.held().next().is_some() || self.simulated_time_stands_still()
    }

    /// Says now and then how far a replay has come.
    pub(crate) fn tell_progress(&mut self) {
        const EVERY_NS: i64 = 5_000_000_000;
        let now = self.clock().now_ns();
        if self.options.replay.is_none() || now < self.next_progress_ns {
            return;
        }
        self.next_progress_ns = now + EVERY_NS;
        let replayer = self.place_of(REPLAYER);
        if let Some(note) = replayer
            .map(|i| &self.children[i].note)
            .filter(|note| note.starts_with("pose "))
        {
            bus::say!("pilot: {note}");
        }
    }
}
