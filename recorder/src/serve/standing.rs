//! What may be said of the tool now: where it is, or why nobody may say. Pure: the workflow, the newest sample and the newest image go in.

use bus::message::{FrameState, Lost, ToolPose, Tracked, Workflow};
use bus::run::RunContext;
use geometry::{Ct, Rigid, Tool};
use scene::{Scene, TrackerSource};

use super::views::Claim;

/// What may be said of the tool at one moment.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Standing {
    /// An image shows this pose, and may claim it.
    Live(u64, Rigid<Ct, Tool>),
    /// The same, and the pose is older than the scene allows.
    Old(u64, Rigid<Ct, Tool>),
    /// There is no pose.
    Lost(String),
    /// No image of the present has come.
    NoImage,
    /// There may be a pose, and the run's workflow does not let it be shown.
    Withheld(&'static str),
    /// Nothing more will come: why.
    Ended(&'static str),
}

impl Standing {
    /// Of the `workflow` that was told last, the `newest` sample of the tool, what the newest image claims, and the sample that it `shows`.
    ///
    /// An image is drawn after its pose, and by a program that may be slow: the newest sample can only take away what an image claims.
    pub(super) fn of(
        workflow: Option<&Workflow>,
        newest: Option<&ToolPose>,
        claim: Option<&Claim>,
        shows: Option<&ToolPose>,
        now_ns: i64,
    ) -> Self {
        if let Some(why) = withheld(workflow) {
            return Self::Withheld(why);
        }
        let Some(claim) = claim else { return Self::NoImage };
        if let Some(Err(words)) = newest.map(|newest| pose(newest, now_ns)) {
            return Self::Lost(words);
        }
        let shown = match shows.map(|shows| pose(shows, now_ns)) {
            None => Err("the pose of the newest image did not come here".to_owned()),
            Some(shown) => shown,
        };
        match (claim.state, shown) {
            (Some(FrameState::Lost(reason)), _) => Self::Lost(reason.words().to_owned()),
            (Some(FrameState::Live), Ok(pose)) => Self::Live(claim.seq, pose),
            (Some(FrameState::Stale), Ok(pose)) => Self::Old(claim.seq, pose),
            (Some(FrameState::Live | FrameState::Stale), Err(words)) => Self::Lost(words),
            (Some(FrameState::Requested | FrameState::Look) | None, _) => Self::NoImage,
        }
    }

    /// Whether there is a pose to be drawn.
    pub(super) const fn has_pose(&self) -> bool {
        matches!(self, Self::Live(..) | Self::Old(..))
    }

    /// In words.
    pub(super) fn words(&self) -> String {
        match self {
            Self::Live(seq, _) => format!("pose {seq}"),
            Self::Old(seq, _) => format!("POSE OLD, pose {seq}"),
            Self::Lost(why) => format!("NO POSE: {why}"),
            Self::NoImage => "NO POSE: no image of the present".to_owned(),
            Self::Withheld(why) => format!("WITHHELD: {why}"),
            Self::Ended(why) => (*why).to_owned(),
        }
    }
}

fn pose(sample: &ToolPose, now_ns: i64) -> Result<Rigid<Ct, Tool>, String> {
    match sample.tracked_at(now_ns) {
        Ok(Tracked::Valid(pose)) => Ok(pose),
        Ok(Tracked::Lost(reason)) => Err(reason.words().to_owned()),
        Err(_) => Err(Lost::Refused.words().to_owned()),
    }
}

/// Why nothing may be shown of the tool, whatever its pose is: as for clients of the gateway.
pub(super) fn withheld(workflow: Option<&Workflow>) -> Option<&'static str> {
    let Some(workflow) = workflow else {
        return Some("the run has not said yet how far it has come");
    };
    if workflow.has(Workflow::IMAGES) {
        return None;
    }
    Some(match workflow {
        told if told.has(Workflow::REJECTED) => "the examination is said not to be the patient's",
        told if told.has(Workflow::BUMPED) => "the marker on the patient was pushed",
        told if told.has(Workflow::CHECK_FAILED) => "the check of the registration failed",
        _ => "the run is not ready for navigation",
    })
}

/// What a run's poses come from, in words; empty for a localizer's in the present.
pub(super) fn origin(run: &RunContext, scene: &Scene) -> &'static str {
    if run.replay.is_some() {
        return "REPLAY, NOT LIVE";
    }
    if run.simulated_time {
        return "SIMULATED TIME, NOT LIVE";
    }
    match scene.tracker.source {
        TrackerSource::Simulated(_) | TrackerSource::OperatingRoom(_) => "SIMULATED TRACKER",
        TrackerSource::Sequence(_) => "TRACKER PLAYS A FILE",
        TrackerSource::Emitters(_) | TrackerSource::Markers(_) | TrackerSource::External => "",
    }
}

#[cfg(test)]
mod tests;
