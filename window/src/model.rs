//! What the screen shows, as one value: made of what came over the bus, painted by [`crate::screen`].
//!
//! Pure: the messages and the time are handed in, so that every state of the screen can be made in a test. Whatever cannot be known is
//! a reason in words, never an old value.

mod cells;
mod facts;
mod organs;
mod replay;
mod sight;
mod state;
mod steps;

pub use cells::{Cell, cells};
pub use facts::{Facts, facts};
pub use organs::{Organs, organs};
pub use replay::{ReplayModel, at_ns, replay};
pub use sight::{Aimed, aimed};
pub use state::{ScreenState, Tone, state};
pub use steps::{Rung, StepsModel, steps};

use std::rc::Rc;

use bus::gather::{PoseId, Set};
use bus::message::{
    Ages, ClockLaw, FrameHeader, FrameStamp, FrameState, Guide, Heartbeat, Identity, Images, Steps, Timeline, ToolPose,
    VolumeHash, Workflow,
};
use scene::{Plane, Scene};

/// What has come over the bus.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// The run's scene.
    pub scene: &'a Scene,
    /// Now, ns on the session's clock.
    pub now_ns: i64,
    /// Of each view of the scene, in its order: the image chosen to be shown.
    pub headers: &'a [Option<FrameHeader>],
    /// How the images belong together; `None` where there is none.
    pub set: Option<Set>,
    /// The newest poses, oldest first.
    pub poses: &'a [ToolPose],
    /// What is aimed at.
    pub guide: Option<Guide>,
    /// How far the run has come.
    pub workflow: Option<Workflow>,
    /// Where a person is on her way through calibration, registration and check.
    pub steps: Option<Steps>,
    /// Whose examination it is.
    pub identity: Option<Identity>,
    /// The run's examination.
    pub volume: Option<VolumeHash>,
    /// The recorder's newest sign of life, and how old it is, ns; `None` where the scene records nothing.
    pub recorder: Option<(Option<Heartbeat>, i64)>,
    /// How long ago a picture of this screen was read back by the program that watches it, ns; `None` where none was.
    pub watched_ns: Option<i64>,
    /// The localizer says what is got over by starting it anew: that poses may be older than their stamps, that it waits to be told to dial.
    pub may_restart_localizer: bool,
    /// Poses come out of a recording.
    pub is_replay: bool,
    /// In a replay, and in simulated time: the clock as it was told last.
    pub law: Option<ClockLaw>,
    /// In a replay: what the recording holds over its time.
    pub timeline: Option<&'a Rc<Timeline>>,
    /// In a replay: the examination that the recording was made in.
    pub recorded_in: Option<Recorded<'a>>,
    /// Time is simulated.
    pub is_simulated: bool,
    /// When the navigation began, ns on the session's clock.
    pub began_ns: Option<i64>,
}

impl Known<'_> {
    /// The image that the sight and the numbers are in step with.
    fn sighted(&self) -> Option<FrameHeader> {
        sighted(self.scene, self.headers)
    }

    /// The pose of an image, with what images do not carry; `None` where it has not come.
    fn pose_of(&self, header: &FrameHeader) -> Option<&ToolPose> {
        pose_of(self.poses, PoseId::of(&header.stamp))
    }

    /// How many views show a pose that has long been none while others are live: nobody draws them, and the tracker is well. 0 where
    /// there is a view that says itself that there is no pose, or none that is live.
    fn standing_still(&self) -> usize {
        let images = self.headers.iter().flatten().map(|header| header.stamp);
        let is_lost = |state: Option<FrameState>| matches!(state, Some(FrameState::Lost(_)));
        let is_live = |stamp: FrameStamp| stamp.state_at(self.now_ns, self.ages()) == Some(FrameState::Live);
        match images.clone().any(|stamp| is_lost(stamp.frame_state())) || !images.clone().any(is_live) {
            true => 0,
            false => images
                .filter(|stamp| is_lost(stamp.state_at(self.now_ns, self.ages())))
                .count(),
        }
    }

    /// When poses grow old.
    pub fn ages(&self) -> Ages {
        Ages::of(&self.scene.limits)
    }
}

/// Of the images shown, that which the sight and the numbers are in step with: that across the tube, or else the slice, or the overview, of the newest pose.
pub(crate) fn sighted(scene: &Scene, headers: &[Option<FrameHeader>]) -> Option<FrameHeader> {
    let views = scene.views.iter().zip(headers);
    let mut across = views.filter(|(view, _)| view.plane == Plane::Perpendicular);
    let newest = |of_surfaces: bool| {
        let views = scene.views.iter().zip(headers);
        let of_kind = views.filter(|(view, _)| (view.plane == Plane::Surface) == of_surfaces);
        let headers = of_kind.filter_map(|(_, header)| *header);
        headers.max_by_key(|header| header.stamp.t_capture_ns)
    };
    // Overviews have organs at rest: they are asked where there is nothing else.
    let across = across.find_map(|(_, header)| *header);
    across.or_else(|| newest(false)).or_else(|| newest(true))
}

/// Which of the poses it is; `None` where it is none of them.
pub(crate) fn pose_of(poses: &[ToolPose], id: PoseId) -> Option<&ToolPose> {
    let is_it = |pose: &&ToolPose| pose.seq == id.seq && pose.t_capture_ns == id.t_capture_ns;
    poses.iter().rev().find(is_it)
}

/// The examination that a recording was made in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recorded<'a> {
    /// The one with this hash, in hex.
    In(&'a str),
    /// It does not say.
    Unknown,
}

/// What the screen shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The state of the whole screen.
    pub state: ScreenState,
    /// Of each view, in the order of the screen.
    pub cells: Vec<Cell>,
    /// The sight, or why there is none.
    pub sight: Result<Aimed, String>,
    /// What a model of organs says of the tube; `None` where the scene has none.
    pub organs: Option<Organs>,
    /// What everything rests on.
    pub facts: Facts,
    /// The way to a navigation; `None` where the run has no steps and demands none.
    pub steps: Option<StepsModel>,
    /// Where a replay stands.
    pub replay: Option<ReplayModel>,
    /// Whether images look otherwise than the scene says.
    pub are_images_changed: bool,
    /// See [`Known::may_restart_localizer`].
    pub may_restart_localizer: bool,
}

impl Model {
    /// What is to be shown of what is known.
    pub fn of(known: &Known<'_>) -> Self {
        let state = state(known);
        Self {
            cells: cells(known, &state),
            sight: aimed(known, &state),
            organs: organs(known),
            facts: facts(known, &state),
            steps: steps(known),
            replay: replay(known),
            may_restart_localizer: known.may_restart_localizer,
            are_images_changed: known.guide.is_some_and(|guide| guide.images() != Ok(Images::default())),
            state,
        }
    }
}

#[cfg(test)]
pub(crate) mod sample;
#[cfg(test)]
mod tests;
