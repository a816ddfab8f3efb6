//! The one table of topics. Every port is opened from a row of it, and `pilot topics` prints it.

use std::time::Duration;

/// How the payload of a topic moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pattern {
    /// One publisher, many subscribers, newest wins where the subscriber's buffer is 1.
    PublishSubscribe,
    /// Clients ask, one server answers.
    RequestResponse,
}

/// A row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Topic {
    /// The service's name; `*` stands for a process or view of the scene.
    pub name: &'static str,
    /// The versioned name of its payload.
    pub payload: &'static str,
    /// How it moves.
    pub pattern: Pattern,
    /// How many publishers or servers may exist at a time.
    pub publishers: usize,
    /// How many subscribers or clients may exist at a time.
    pub subscribers: usize,
    /// How many samples a late subscriber is given.
    pub history: usize,
    /// Deepest buffer a subscriber may ask for.
    pub buffer: usize,
    /// How many samples a subscriber may hold at a time.
    pub borrowed: usize,
    /// After this silence a receiver must treat what it has as old.
    pub deadline: Option<Duration>,
    /// Whether each sample also wakes its receivers.
    pub wakes: bool,
    /// What it is for.
    pub purpose: &'static str,
}

const BASE: Topic = Topic {
    name: "",
    payload: "",
    pattern: Pattern::PublishSubscribe,
    publishers: 1,
    subscribers: 24,
    history: 1,
    buffer: 1,
    borrowed: 2,
    deadline: None,
    wakes: false,
    purpose: "",
};

/// The examination, once, in shared memory. Two may be borrowed, so that a reader can change over to a reloaded one.
pub const VOLUME: Topic = Topic {
    name: "volume",
    payload: "trocar/VolumeHeader/1 + [i16]",
    purpose: "the CT: one copy for all processes",
    ..BASE
};

/// The tool's pose. Renderers take the newest; the recorder and the pilot ask for a deep buffer.
pub const TOOL_POSE: Topic = Topic {
    name: "tool-pose",
    payload: "trocar/ToolPose/2",
    buffer: 4096,
    deadline: Some(Duration::from_millis(100)),
    wakes: true,
    purpose: "ct_from_tool with its status, from the tracker",
    ..BASE
};

/// What the localizer saw, before poses are made of it: for the recorder, and for poses made again from a recording. Few
/// listen, as frames are large.
pub const EMITTERS: Topic = Topic {
    name: "emitters",
    payload: "trocar/EmitterFrame/1",
    subscribers: 4,
    buffer: 4096,
    wakes: true,
    purpose: "places of the emitters that the localizer saw",
    ..BASE
};

/// The poses of markers, from a localizer that makes them itself, before the chain to the patient. Few listen, as for emitters.
pub const MARKERS: Topic = Topic {
    name: "markers",
    payload: "trocar/MarkerFrame/1",
    subscribers: 4,
    buffer: 4096,
    wakes: true,
    purpose: "poses of the markers that the localizer follows, each frame of one instant",
    ..BASE
};

/// The images of a tracked ultrasound probe. Few listen, as images are large; a reader may be late by some.
pub const US_IMAGE: Topic = Topic {
    name: "us-image",
    payload: "trocar/UsImageHeader/2 + [u8] grey",
    subscribers: 4,
    buffer: 8,
    purpose: "images of a tracked ultrasound probe",
    ..BASE
};

/// The organs that the tube moves, at rest, once.
pub const TISSUE_MESH: Topic = Topic {
    name: "tissue-mesh",
    payload: "trocar/TissueMeshHeader/1 + [u8]",
    purpose: "the organs that the tube moves, at rest (scenes with tissue only)",
    ..BASE
};

/// Where the tube has moved them. Renderers take the newest; the recorder asks for a deep buffer.
pub const TISSUE: Topic = Topic {
    name: "tissue",
    payload: "trocar/TissueHeader/3 + [f32]",
    buffer: 64,
    deadline: Some(Duration::from_millis(100)),
    wakes: true,
    purpose: "where the tube has moved organs: nodes, for one pose, with what certifies them (scenes with tissue only)",
    ..BASE
};

/// Of which poses a recording has states, told before each, where a replay has them made again.
pub const TISSUE_ASKED: Topic = Topic {
    name: "tissue-asked",
    payload: "trocar/TissueHeader/3",
    buffer: 64,
    purpose: "which poses a model answers again, in a replay that recomputes tissue",
    ..BASE
};

/// Where the simulated tool truly is.
pub const GROUND_TRUTH: Topic = Topic {
    name: "ground-truth",
    payload: "trocar/ToolPose/2",
    buffer: 4096,
    purpose: "the simulated tool's true pose (simulated tracker only)",
    ..BASE
};

/// The clock of a replay, of another machine's run, or simulated time. There is none in a run that navigates here.
pub const SESSION_CLOCK: Topic = Topic {
    name: "session-clock",
    payload: "trocar/ClockLaw/3",
    purpose: "the clock of a replay, of another machine's run, or simulated time (these only)",
    ..BASE
};

/// What the recording that is replayed holds over its time.
pub const TIMELINE: Topic = Topic {
    name: "timeline",
    payload: "trocar/Timeline/1",
    purpose: "what a recording holds over its time: states, errors, marks (replays with a window only)",
    ..BASE
};

/// The images of one view.
pub const VIEW_FRAME: Topic = Topic {
    name: "view/*",
    payload: "trocar/FrameHeader/7 + [u8] RGBA",
    // A viewer holds the set that it shows and two that gather, and is handed one more.
    borrowed: 4,
    deadline: Some(Duration::from_millis(100)),
    wakes: true,
    purpose: "the newest image of one view",
    ..BASE
};

/// Images that were asked for: on a topic of their own, so that live ones never replace them.
pub const HELD_FRAME: Topic = Topic {
    name: "held/*",
    payload: "trocar/FrameHeader/7 + [u8] RGBA",
    purpose: "the image of one view for the pose that was asked for last",
    ..BASE
};

/// Images of a plane that was asked for, whatever the tool does.
pub const LOOK_FRAME: Topic = Topic {
    name: "look/*",
    payload: "trocar/FrameHeader/7 + [u8] RGBA",
    wakes: true,
    purpose: "the image of one view for the plane that was asked for last",
    ..BASE
};

/// Whose examination it is. A few readers: it is a person's, and goes into no recording unless the scene says so.
pub const IDENTITY: Topic = Topic {
    name: "identity",
    payload: "trocar/Identity/1",
    subscribers: 8,
    purpose: "whose examination it is, as the examination or the scene says",
    ..BASE
};

/// What is aimed at and what is held: a person's choice, kept by the pilot, in a replay by the recording. The newest are kept, so
/// that who joins late knows also what was chosen when an earlier pose was captured.
pub const GUIDE: Topic = Topic {
    name: "guide",
    payload: "trocar/Guide/2",
    history: 64,
    buffer: 256,
    wakes: true,
    purpose: "the chosen target with its entry and stop, the pose that is held, and how images look",
    ..BASE
};

/// The plan of the operation, in a planning run: kept and written by its pilot.
pub const PLAN: Topic = Topic {
    name: "plan",
    payload: "trocar/Plan/2",
    wakes: true,
    purpose: "targets, ways to them and what was measured (planning runs only)",
    ..BASE
};

/// How far the run has come, and what may be shown.
pub const WORKFLOW: Topic = Topic {
    name: "workflow",
    payload: "trocar/Workflow/3",
    buffer: 256,
    wakes: true,
    purpose: "how far the run has come from loading to navigating, and what it skipped",
    ..BASE
};

/// Where a person is on her way through calibration, registration and check, and what came of it so far.
pub const STEPS: Topic = Topic {
    name: "steps",
    payload: "trocar/Steps/2",
    wakes: true,
    purpose: "the guided calibration, registration and check: what is to be done, and how good it is (scenes with steps only)",
    ..BASE
};

/// The stamps of all images of one renderer.
pub const FRAME_STAMP: Topic = Topic {
    name: "stamp/*",
    payload: "trocar/FrameStamp/6",
    buffer: 1024,
    purpose: "what each image of a process showed and when: for latency and state",
    ..BASE
};

/// Signs of life.
pub const HEARTBEAT: Topic = Topic {
    name: "heartbeat/*",
    payload: "trocar/Heartbeat/2",
    deadline: Some(Duration::from_secs(2)),
    purpose: "state and counters of one process",
    ..BASE
};

/// What a process did or was asked to do, in words: for the recording. The newest are kept for a recorder that joins late.
pub const EVENT: Topic = Topic {
    name: "event/*",
    payload: "trocar/Event/1",
    subscribers: 4,
    history: 64,
    buffer: 256,
    purpose: "what a process did or was asked to do, in words",
    ..BASE
};

/// Requests to a process.
pub const COMMAND: Topic = Topic {
    name: "command/*",
    payload: "trocar/Command/7 -> trocar/ReplyHeader/1 + [u8]",
    pattern: Pattern::RequestResponse,
    history: 0,
    wakes: true,
    purpose: "status, stop, restart, choose, images, mark, hold, confirm, navigate, checked, change the plan (pilot), steps (calib), practise (simulated tracker), render one pose, one plane or none, see a surface from elsewhere (renderers), steer a replay (replayer)",
    ..BASE
};

/// The table.
pub const TOPICS: [&Topic; 23] = [
    &VOLUME,
    &TOOL_POSE,
    &EMITTERS,
    &MARKERS,
    &US_IMAGE,
    &TISSUE_MESH,
    &TISSUE,
    &TISSUE_ASKED,
    &GROUND_TRUTH,
    &SESSION_CLOCK,
    &TIMELINE,
    &VIEW_FRAME,
    &HELD_FRAME,
    &LOOK_FRAME,
    &IDENTITY,
    &GUIDE,
    &PLAN,
    &WORKFLOW,
    &STEPS,
    &FRAME_STAMP,
    &HEARTBEAT,
    &EVENT,
    &COMMAND,
];

impl Topic {
    /// The service's name for one process or view.
    pub fn of(&self, part: &str) -> String {
        self.name.replace('*', part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_writer_and_unique_names() {
        for (i, topic) in TOPICS.iter().enumerate() {
            assert_eq!(topic.publishers, 1, "{}", topic.name);
            assert!(TOPICS[i + 1..].iter().all(|other| other.name != topic.name));
        }
        assert_eq!(VIEW_FRAME.of("axial-local"), "view/axial-local");
    }
}
