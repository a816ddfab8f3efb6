//! `pilot status`: the state of a run, as JSON for scripts and as a table for people.

use bus::clock;
use bus::message::{FrameState, ToolPose, Tracked};
use serde::{Deserialize, Serialize};

use crate::plan::Planned;
use crate::replay::ReplayStatus;
use crate::spawn::Running;
use crate::state::Run;

/// The state of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Status {
    pub(crate) run: String,
    pub(crate) scene: String,
    /// Where a replay stands; `null` in a run that navigates.
    pub(crate) replay: Option<ReplayStatus>,
    /// Seconds since navigation began; negative before.
    pub(crate) navigating_s: f64,
    pub(crate) processes: Vec<ProcessStatus>,
    pub(crate) views: Vec<ViewStatus>,
    pub(crate) pose: Option<PoseStatus>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ProcessStatus {
    pub(crate) name: String,
    pub(crate) pid: Option<u32>,
    /// waiting, starting, ready, restarting, held, ending, ended
    pub(crate) stage: String,
    pub(crate) note: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ViewStatus {
    pub(crate) name: String,
    /// live (in a replay: replay; in simulated time: simulated), stale, lost, down, waiting
    pub(crate) state: String,
    pub(crate) seq: Option<u64>,
    /// Age of the pose it shows, ms.
    pub(crate) age_ms: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PoseStatus {
    pub(crate) seq: u64,
    /// valid, or why there is none
    pub(crate) state: String,
    pub(crate) age_ms: f64,
    /// Predicted error at the tip, 95 %, mm; `null`: not known.
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
        let process = |(i, planned): (usize, &Planned)| ProcessStatus {
            name: planned.name.clone(),
            pid: run.running[i].as_ref().map(Running::pid),
            stage: run.supervisor.stage_word(i).to_owned(),
            note: run.notes[i].clone(),
        };
        Self {
            run: run.options.run.clone(),
            scene: run.source.path.display().to_string(),
            replay: ReplayStatus::of(run),
            navigating_s: run
                .began_ns
                .map_or(0.0, |began| clock::ms(run.clock().now_ns() - began) / 1e3),
            processes: run.planned.iter().enumerate().map(process).collect(),
            views: (0..run.scene.views.len())
                .map(|view| view_status(run, view, now))
                .collect(),
            pose: run.books.newest_pose().map(|pose| pose_status(pose, now)),
        }
    }

    /// The table for people.
    pub(crate) fn table(&self) -> String {
        let mut lines = vec![format!(
            "run {:?}, scene {}, navigating for {:.1} s",
            self.run, self.scene, self.navigating_s
        )];
        lines.extend(self.replay.as_ref().map(ReplayStatus::line));
        if let Some(pose) = &self.pose {
            lines.push(pose.line());
        }
        lines.push(format!("{:<22}{:>8}  {:<11}{}", "process", "pid", "stage", "note"));
        for p in &self.processes {
            let pid = p.pid.map_or("-".to_owned(), |pid| pid.to_string());
            lines.push(format!("{:<22}{pid:>8}  {:<11}{}", p.name, p.stage, p.note));
        }
        lines.push(format!("{:<22}{:>8}  {:<11}{}", "view", "pose", "state", "age"));
        for v in &self.views {
            let seq = v.seq.map_or("-".to_owned(), |seq| seq.to_string());
            let age = v.age_ms.map_or("-".to_owned(), |ms| format!("{ms:.0} ms"));
            lines.push(format!("{:<22}{seq:>8}  {:<11}{age}", v.name, v.state));
        }
        lines.join("\n")
    }
}

fn view_status(run: &Run, view: usize, now: i64) -> ViewStatus {
    let process = run.planned.iter().position(|p| p.views.contains(&view)).unwrap_or(0);
    let last = run.books.views[view].last;
    let stale_ns = clock::ns(run.scene.limits.stale);
    let state = match last.and_then(|stamp| stamp.state_at(now, stale_ns)) {
        _ if !run.supervisor.is_ready(process) => "down",
        None => "waiting",
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
        age_ms: last.map(|stamp| clock::ms(now - stamp.t_capture_ns)),
    }
}

fn pose_status(pose: &ToolPose, now: i64) -> PoseStatus {
    PoseStatus {
        seq: pose.seq,
        state: match pose.tracked() {
            Ok(Tracked::Valid(_)) => "valid".to_owned(),
            Ok(Tracked::Lost(reason)) => reason.words().to_owned(),
            Err(error) => error.to_string(),
        },
        age_ms: clock::ms(now - pose.t_capture_ns),
        tip_95_mm: pose.tip_95_mm(),
        outside: pose.outside(),
        smoothing_delay_ms: clock::ms(pose.delay_ns),
    }
}

impl PoseStatus {
    fn line(&self) -> String {
        let mut line = format!("pose {}: {}, {:.0} ms old", self.seq, self.state, self.age_ms);
        if self.state != "valid" {
            return line;
        }
        line += &match self.tip_95_mm {
            Some(mm) => format!(", tip ±{mm:.2} mm (95 %)"),
            None => ", tip error not known".to_owned(),
        };
        if self.outside {
            line += ", TIP OUTSIDE THE CT";
        }
        if self.smoothing_delay_ms > 0.0 {
            line += &format!(", smoothed: {:.0} ms late", self.smoothing_delay_ms);
        }
        line
    }
}
