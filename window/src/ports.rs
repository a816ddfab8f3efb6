//! The window's ends of the topics.

use bus::message::{Guide, Heartbeat, Identity, Steps, Timeline, ToolPose, Workflow};
use bus::port::{FrameSubscriber, Subscriber};
use bus::run::RunContext;
use bus::topic::{GUIDE, HEARTBEAT, HELD_FRAME, IDENTITY, STEPS, TIMELINE, TOOL_POSE, WORKFLOW};
use bus::wake::Waits;
use bus::{Bus, BusError};
use scene::Scene;

/// As many poses as may come between two frames of a window that is held up for a second.
const POSES: usize = 256;

/// Everything that a screen listens to.
#[derive(Debug)]
pub struct Ports {
    /// Of each view of the scene: its live images.
    pub views: Vec<FrameSubscriber>,
    /// Of each view: the image of the pose held.
    pub held: Vec<FrameSubscriber>,
    /// For the sight: images do not carry the pose's covariance.
    pub poses: Subscriber<ToolPose>,
    /// What is aimed at.
    pub guide: Subscriber<Guide>,
    /// How far the run has come.
    pub workflow: Subscriber<Workflow>,
    /// Where a person is on her way to navigation, where the scene has steps.
    pub steps: Option<Subscriber<Steps>>,
    /// What the recording holds, in a replay.
    pub timeline: Option<Subscriber<Timeline>>,
    /// Whose examination it is.
    pub identity: Subscriber<Identity>,
    /// The recorder's signs of life, where the scene records.
    pub recorder: Option<Subscriber<Heartbeat>>,
    /// Those of the program that reads the screen back.
    pub watcher: Subscriber<Heartbeat>,
    /// Those of the localizer, where this run has one.
    pub localizer: Option<Subscriber<Heartbeat>>,
}

/// What a run has beside images and poses; nothing of it by default.
#[derive(Debug, Clone, Copy, Default)]
pub struct Has {
    /// It replays a recording.
    pub replay: bool,
    /// Somebody guides calibration, registration and check.
    pub steps: bool,
    /// A localizer of its own. A second machine's run has none: the first one's is not started anew from there.
    pub localizer: bool,
}

impl Has {
    /// As the pilot starts them.
    pub fn of(run: &RunContext, scene: &Scene) -> Self {
        let is_live = run.replay.is_none() && !run.simulated_time;
        Self {
            replay: run.replay.is_some(),
            steps: scene.steps.is_some() && is_live,
            localizer: scene.localizer.is_some() && is_live && run.remote.is_none(),
        }
    }
}

impl Ports {
    /// Opens them all.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, scene: &Scene, has: Has) -> Result<Self, BusError> {
        let names = || scene.views.iter().map(|view| view.name.as_str());
        let records = scene.recording.is_some();
        Ok(Self {
            views: names()
                .map(|name| FrameSubscriber::open_waking(bus, name))
                .collect::<Result<_, _>>()?,
            held: names()
                .map(|name| FrameSubscriber::open(bus, &HELD_FRAME, name))
                .collect::<Result<_, _>>()?,
            poses: Subscriber::open(bus, &TOOL_POSE, "", POSES)?,
            guide: Subscriber::open_waking(bus, &GUIDE, "", 1)?,
            workflow: Subscriber::open_waking(bus, &WORKFLOW, "", 1)?,
            steps: has
                .steps
                .then(|| Subscriber::open_waking(bus, &STEPS, "", 1))
                .transpose()?,
            timeline: has
                .replay
                .then(|| Subscriber::open(bus, &TIMELINE, "", 1))
                .transpose()?,
            identity: Subscriber::open(bus, &IDENTITY, "", 1)?,
            recorder: records
                .then(|| Subscriber::open(bus, &HEARTBEAT, "recorder", 1))
                .transpose()?,
            watcher: Subscriber::open(bus, &HEARTBEAT, crate::watch::NAME, 1)?,
            localizer: has
                .localizer
                .then(|| Subscriber::open(bus, &HEARTBEAT, "localizer", 1))
                .transpose()?,
        })
    }

    /// Wakes for whatever changes the screen. The images do: each pose leads to some.
    pub fn waits<'a>(&'a self, waits: Waits<'a>) -> Waits<'a> {
        let waits = waits.message(&self.guide, None).message(&self.workflow, None);
        let waits = self.steps.iter().fold(waits, |waits, steps| waits.message(steps, None));
        self.views.iter().fold(waits, Waits::frames)
    }
}
