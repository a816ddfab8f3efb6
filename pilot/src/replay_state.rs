//! Where a replay stands, and how a run ends that is one.

use bus::message::ReplayState;
use serde::{Deserialize, Serialize};

use crate::plan::REPLAYER;
use crate::replay::{ACCOUNT, ReplayReport};
use crate::state::{Options, Run};

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
        if let Some(remote) = &self.remote {
            let until = match self.duration {
                Some(duration) => format!("for {:.1} s", duration.as_secs_f64()),
                None => format!("until `pilot stop --run {}` or Ctrl-C", self.run),
            };
            return format!("showing run {:?} of {} {until}", remote.facts.run, remote.endpoint);
        }
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
            (None, None) if self.planning.is_some() => {
                format!("planning until `pilot stop --run {}` or Ctrl-C", self.run)
            }
            (None, None) => format!("navigating until `pilot stop --run {}` or Ctrl-C", self.run),
        }
    }
}

impl Run {
    /// What the report says of the replay, where the run is one.
    pub(crate) fn replay_report(&self) -> Option<ReplayReport> {
        let replay = self.options.replay.as_ref()?;
        let shown = self.metrics.volume_hash().map(|hash| hash.to_string());
        Some(ReplayReport {
            recording: replay.recording.display().to_string(),
            recorded_run: replay.facts.run.clone(),
            recorded_registration_id: replay.facts.registration_id.clone(),
            same_volume: shown.is_some() && shown == replay.facts.volume_hash,
            recorded_volume_hash: replay.facts.volume_hash.clone(),
            speed: replay.speed.clone(),
            from_s: replay.seconds(replay.span_ns[0]),
            to_s: replay.seconds(replay.span_ns[1]),
            damage: match replay.facts.damage.is_empty() {
                true => unread(&self.options.out),
                false => replay.facts.damage.clone(),
            },
            recomputed: self.recomputed.clone(),
        })
    }

    /// Whether the last pose of a replay, or of a run in simulated time, has gone out.
    pub(crate) fn replay_has_ended(&self) -> bool {
        // On a screen it stands at its end, and can be sent elsewhere.
        let stays = self.options.replay.is_some() && self.options.has_window;
        let law = self.session.replay().filter(|_| !stays);
        law.is_some_and(|law| law.replay_state() == ReplayState::Ended)
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
            bus::stderr_line!("pilot: {note}");
        }
    }
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
