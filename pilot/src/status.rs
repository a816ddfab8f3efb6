//! `pilot status`: the state of a run, as JSON for scripts and as a table for people.

use bus::clock;
use bus::message::{Ages, FrameStamp, FrameState, Lost, ToolPose, Tracked};
use serde::{Deserialize, Serialize};

use crate::child::Child;
use crate::guiding::GuidingStatus;
use crate::metrics::Restart;
use crate::problems::times;
use crate::replay_state::ReplayStatus;
use crate::spawn::Running;
use crate::state::Run;

/// A process whose work has said nothing for so long is said to stand still: ten signs of life are missing.
const STANDSTILL_NS: i64 = 1_000_000_000;

/// The state of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Status {
    pub(crate) run: String,
    pub(crate) scene: String,
    /// Where a replay stands; `null` in a run that navigates.
    pub(crate) replay: Option<ReplayStatus>,
    /// Seconds since navigation began; negative before.
    pub(crate) navigating_s: f64,
    /// How far the run has come, and what a person chose.
    #[serde(default)]
    pub(crate) guiding: GuidingStatus,
    pub(crate) processes: Vec<ProcessStatus>,
    pub(crate) views: Vec<ViewStatus>,
    /// Whether the images show one pose.
    pub(crate) set: SetStatus,
    pub(crate) pose: Option<PoseStatus>,
    /// Processes that died and whose places on the bus could not be freed.
    #[serde(default)]
    pub(crate) dead_processes_left: u64,
    /// Topics with hardly a place left for another reader, with those who hold them.
    #[serde(default)]
    pub(crate) crowded: Vec<String>,
}

/// The live images taken together: those of different poses must not be read side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SetStatus {
    /// one pose, different poses, incomplete (a view has no image, or its process is not there)
    pub(crate) state: String,
    /// The lowest number of a pose shown.
    pub(crate) oldest_seq: Option<u64>,
    /// And the highest.
    pub(crate) newest_seq: Option<u64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ProcessStatus {
    pub(crate) name: String,
    pub(crate) pid: Option<u32>,
    /// waiting, starting, ready, restarting, held, ending, ended
    pub(crate) stage: String,
    pub(crate) note: String,
    /// How often it ended before the run did, and why the last time.
    #[serde(default)]
    pub(crate) endings: usize,
    #[serde(default)]
    pub(crate) last_ending: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ViewStatus {
    pub(crate) name: String,
    /// live (in a replay: replay; in simulated time: simulated), stale, lost, held (asked for), down, waiting
    pub(crate) state: String,
    pub(crate) seq: Option<u64>,
    /// Age of the pose it shows, ms.
    pub(crate) age_ms: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PoseStatus {
    pub(crate) seq: u64,
    /// valid; stale (older than `limits.stale_ms`); or why there is none
    pub(crate) state: String,
    pub(crate) age_ms: f64,
    /// Predicted error at the tip, 95 %, mm; `null`: not known, or there is no pose.
    pub(crate) tip_95_mm: Option<f64>,
    /// The tip is outside the examination.
    pub(crate) outside: bool,
    /// The delay of smoothing, ms; 0: none.
    pub(crate) smoothing_delay_ms: f64,
}

impl Status {
    /// The state of `run` at this moment.
    pub(crate) fn of(run: &Run) -> Self {
        let now = run.session.clock().now_ns();
        let is_here = |(pose, _): &&(ToolPose, Tracked)| !run.session.is_yet_to_come(pose.t_publish_ns);
        let process = |(i, child): (usize, &Child)| ProcessStatus {
            name: child.name().to_owned(),
            pid: run.children[i].running.as_ref().map(Running::pid),
            stage: run.supervisor.stage_word(i).to_owned(),
            note: note(run, i),
            endings: run.metrics.endings_of(child.name()).count(),
            last_ending: run.metrics.endings_of(child.name()).last().map(Restart::words),
        };
        let views: Vec<ViewStatus> = (0..run.scene.views.len())
            .map(|view| view_status(run, view, now))
            .collect();
        Self {
            run: run.options.run.clone(),
            scene: run.source.path.display().to_string(),
            replay: ReplayStatus::of(run),
            navigating_s: run
                .began_ns
                .map_or(0.0, |began| clock::ms(run.clock().now_ns() - began) / 1e3),
            guiding: run.guiding.status(),
            processes: run.children.iter().enumerate().map(process).collect(),
            set: SetStatus::of(&views),
            views,
            pose: run
                .metrics
                .newest()
                .filter(is_here)
                .map(|newest| pose_status(run, newest, now)),
            dead_processes_left: run.dead_processes_left,
            crowded: run.crowded.iter().map(ToString::to_string).collect(),
        }
    }

    /// The table for people.
    pub(crate) fn table(&self) -> String {
        let mut lines = vec![format!(
            "run {:?}, scene {}, navigating for {:.1} s",
            self.run, self.scene, self.navigating_s
        )];
        lines.extend(self.replay.as_ref().map(ReplayStatus::line));
        lines.push(self.guiding.line());
        if let Some(pose) = &self.pose {
            lines.push(pose.line());
        }
        lines.push(format!("{:<22}{:>8}  {:<11}{}", "process", "pid", "stage", "note"));
        for p in &self.processes {
            let pid = p.pid.map_or("-".to_owned(), |pid| pid.to_string());
            let ended = p.last_ending.as_ref().map_or(String::new(), |last| {
                format!("; ended {}, last {last}", times(p.endings))
            });
            lines.push(format!("{:<22}{pid:>8}  {:<11}{}{ended}", p.name, p.stage, p.note));
        }
        lines.push(format!("{:<22}{:>8}  {:<11}{}", "view", "pose", "state", "age"));
        for v in &self.views {
            let seq = v.seq.map_or("-".to_owned(), |seq| seq.to_string());
            let age = v.age_ms.map_or("-".to_owned(), |ms| format!("{ms:.0} ms"));
            lines.push(format!("{:<22}{seq:>8}  {:<11}{age}", v.name, v.state));
        }
        lines.push(self.set.line());
        if self.dead_processes_left > 0 {
            let left = self.dead_processes_left;
            lines.push(format!("the places of {left} dead processes could not be freed"));
        }
        lines.extend(self.crowded.iter().cloned());
        lines.join("\n")
    }
}

/// What a process said last, and for how long its work has said nothing since.
fn note(run: &Run, i: usize) -> String {
    let now = run.clock().now_ns();
    let silent_ns = run.children[i].standstill.so_far_ns(now);
    match silent_ns > STANDSTILL_NS && run.children[i].running.is_some() {
        true => format!(
            "NO WORD FROM ITS WORK for {:.1} s; {}",
            clock::ms(silent_ns) / 1e3,
            run.children[i].note
        ),
        false => run.children[i].note.clone(),
    }
}

fn view_status(run: &Run, view: usize, now: i64) -> ViewStatus {
    let process = run
        .children
        .iter()
        .position(|child| child.planned.views.contains(&view))
        .unwrap_or(0);
    // What a view showed before a replay went back is none of the place that it is at now: its age there would be below zero.
    let is_here = |stamp: &FrameStamp| !run.session.is_yet_to_come(stamp.t_publish_ns);
    let last = run.metrics.views[view].last.filter(is_here);
    let state = match last.and_then(|stamp| stamp.state_at(now, Ages::of(&run.scene.limits))) {
        _ if !run.supervisor.is_ready(process) => "down",
        None => "waiting",
        Some(FrameState::Requested | FrameState::Look) => "held",
        Some(FrameState::Lost(_)) => "lost",
        Some(FrameState::Live) if run.session.is_replay() => "replay",
        Some(FrameState::Live) if run.session.is_ruled() => "simulated",
        Some(FrameState::Live) => "live",
        Some(FrameState::Stale) => "stale",
    };
    ViewStatus {
        name: run.scene.views[view].name.clone(),
        state: state.to_owned(),
        seq: last.map(|stamp| stamp.seq),
        age_ms: last.map(|stamp| clock::ms(now.saturating_sub(stamp.t_capture_ns))),
    }
}

impl SetStatus {
    fn of(views: &[ViewStatus]) -> Self {
        let is_there = |view: &&ViewStatus| !matches!(view.state.as_str(), "down" | "waiting");
        let seqs = || views.iter().filter(is_there).filter_map(|view| view.seq);
        let (oldest_seq, newest_seq) = (seqs().min(), seqs().max());
        let state = match seqs().count() == views.len() {
            false => "incomplete",
            true if oldest_seq == newest_seq => "one pose",
            true => "different poses",
        };
        Self {
            state: state.to_owned(),
            oldest_seq,
            newest_seq,
        }
    }

    fn line(&self) -> String {
        match (self.state.as_str(), self.oldest_seq, self.newest_seq) {
            ("one pose", Some(pose), _) => format!("all images show pose {pose}"),
            (state, Some(oldest), Some(newest)) => format!("the images are a set of {state}: {oldest} to {newest}"),
            _ => "no image".to_owned(),
        }
    }
}

/// The newest sample as the images show it: an old pose is none, and then nothing is said of how good it was.
fn pose_status(run: &Run, (pose, tracked): &(ToolPose, Tracked), now: i64) -> PoseStatus {
    let age_ns = now.saturating_sub(pose.t_capture_ns);
    let silent = run.held().any(|name| name == "tracker");
    let state = match tracked {
        _ if silent => FrameState::Lost(Lost::Silent),
        _ => Ages::of(&run.scene.limits).of_sample(pose, *tracked, now),
    };
    let words = match state {
        FrameState::Lost(reason) => reason.words(),
        FrameState::Stale => "stale",
        FrameState::Live | FrameState::Requested | FrameState::Look => "valid",
    };
    let is_pose = !matches!(state, FrameState::Lost(_));
    PoseStatus {
        seq: pose.seq,
        state: words.to_owned(),
        age_ms: clock::ms(age_ns),
        tip_95_mm: pose.tip_95_mm().filter(|_| is_pose),
        outside: is_pose && run.metrics.is_outside(tracked),
        smoothing_delay_ms: clock::ms(pose.delay_ns),
    }
}

impl PoseStatus {
    fn line(&self) -> String {
        let mut line = format!("pose {}: {}, {:.0} ms old", self.seq, self.state, self.age_ms);
        if !matches!(self.state.as_str(), "valid" | "stale") {
            return line;
        }
        line += &match self.tip_95_mm {
            Some(mm) if mm < 0.005 => ", tip < 0.01 mm (95 %)".to_owned(),
            Some(mm) => format!(", tip ±{mm:.2} mm (95 %)"),
            None => ", tip error not known".to_owned(),
        };
        if self.outside {
            line += ", TIP OUTSIDE THE LOADED CT";
        }
        if self.smoothing_delay_ms > 0.0 {
            line += &format!(", smoothed: {:.0} ms late", self.smoothing_delay_ms);
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(state: &str, seq: Option<u64>) -> ViewStatus {
        ViewStatus {
            name: "a".to_owned(),
            state: state.to_owned(),
            seq,
            age_ms: None,
        }
    }

    #[test]
    fn images_of_different_poses_are_no_set() {
        let of = |views: &[ViewStatus]| SetStatus::of(views).line();
        assert_eq!(
            of(&[view("live", Some(7)), view("stale", Some(7))]),
            "all images show pose 7"
        );
        let different = [view("live", Some(7)), view("live", Some(9))];
        assert_eq!(of(&different), "the images are a set of different poses: 7 to 9");
        let incomplete = [view("live", Some(7)), view("down", Some(9))];
        assert_eq!(SetStatus::of(&incomplete).state, "incomplete");
        assert_eq!(of(&[view("waiting", None)]), "no image");
    }
}
