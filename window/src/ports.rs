//! The window's ends of the topics.

use bus::message::{Guide, Heartbeat, Identity, Steps, Timeline, ToolPose, Workflow};
use bus::port::{FrameSubscriber, Subscriber};
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
}

impl Ports {
    /// Opens them all; `has_steps` where somebody guides calibration, registration and check, `is_replay` where a recording is replayed.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, scene: &Scene, (is_replay, has_steps): (bool, bool)) -> Result<Self, BusError> {
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
            steps: has_steps
                .then(|| Subscriber::open_waking(bus, &STEPS, "", 1))
                .transpose()?,
            timeline: is_replay.then(|| Subscriber::open(bus, &TIMELINE, "", 1)).transpose()?,
            identity: Subscriber::open(bus, &IDENTITY, "", 1)?,
            recorder: records
                .then(|| Subscriber::open(bus, &HEARTBEAT, "recorder", 1))
                .transpose()?,
            watcher: Subscriber::open(bus, &HEARTBEAT, crate::watch::NAME, 1)?,
        })
    }

    /// Wakes for whatever changes the screen. The images do: each pose leads to some.
    pub fn waits<'a>(&'a self, waits: Waits<'a>) -> Waits<'a> {
        let waits = waits.message(&self.guide, None).message(&self.workflow, None);
        let waits = self.steps.iter().fold(waits, |waits, steps| waits.message(steps, None));
        self.views.iter().fold(waits, Waits::frames)
    }
}
