//! What the tracker can say of the tool, as a state machine: one table, from which each step and the diagram are read.

use std::fmt::Write as _;

use bus::message::Lost;

/// What is known of the tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// No calibration of the tool, or one that was refused.
    NotCalibrated,
    /// No registration of the patient, or one that was refused.
    NotRegistered,
    /// The localizer delivers nothing.
    Stale,
    /// No emitter of the tool is seen.
    NotSeen,
    /// Fewer emitters of the tool are seen than a pose may rest on.
    TooFew,
    /// The emitters do not fit the tool's marker, or its error of fit is too large.
    Residual,
    /// What the localizer says of the tool's marker is no pose, or not to be believed.
    Refused,
    /// The emitters seen do not hold the tip.
    Geometry,
    /// The localizer says that the tool's marker is outside the space in which it measures.
    OutOfVolume,
    /// The localizer says that it is disturbed.
    Interference,
    /// The localizer, or the marker's cable, is not connected.
    Disconnected,
    /// The marker on the patient is not seen, or does not fit.
    ReferenceLost,
    /// The tool is followed, and its tip is outside the examination.
    Outside,
    /// The tool is followed.
    Tracking,
}

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// A calibration of the tool was accepted.
    Calibrated,
    /// It was taken back.
    CalibrationWithdrawn,
    /// A registration of the patient was accepted.
    Registered,
    /// It was taken back.
    RegistrationWithdrawn,
    /// No frame came for longer than the scene's limit.
    Silence,
    /// A frame, and what followed from it.
    Frame(Status),
}

use Status::{
    Disconnected, Geometry, Interference, NotCalibrated, NotRegistered, NotSeen, OutOfVolume, Outside, ReferenceLost,
    Refused, Residual, Stale, TooFew, Tracking,
};

/// What a frame may lead to.
const OUTCOMES: [Status; 11] = [
    NotSeen,
    TooFew,
    Residual,
    Refused,
    Geometry,
    OutOfVolume,
    Interference,
    Disconnected,
    ReferenceLost,
    Outside,
    Tracking,
];
/// States in which frames count.
const LIVE: [Status; 12] = [
    Stale,
    NotSeen,
    TooFew,
    Residual,
    Refused,
    Geometry,
    OutOfVolume,
    Interference,
    Disconnected,
    ReferenceLost,
    Outside,
    Tracking,
];

impl Status {
    /// Every state.
    pub const ALL: [Self; 14] = [
        NotCalibrated,
        NotRegistered,
        Stale,
        NotSeen,
        TooFew,
        Residual,
        Refused,
        Geometry,
        OutOfVolume,
        Interference,
        Disconnected,
        ReferenceLost,
        Outside,
        Tracking,
    ];

    /// Before anything has happened.
    pub const START: Self = NotCalibrated;

    /// In words, for images, reports and the diagram.
    pub const fn words(self) -> &'static str {
        match self {
            NotCalibrated => "tool not calibrated",
            NotRegistered => "patient not registered",
            Stale => "localizer silent",
            NotSeen => "marker not seen",
            TooFew => "too few emitters",
            Residual => Lost::Residual.words(),
            Refused => Lost::Refused.words(),
            Geometry => "emitters do not hold the tip",
            OutOfVolume => Lost::OutOfVolume.words(),
            Interference => Lost::Interference.words(),
            Disconnected => Lost::Disconnected.words(),
            ReferenceLost => "reference lost",
            Outside => "tip outside the CT",
            Tracking => "tracking",
        }
    }

    /// Whether a pose is published in this state.
    pub const fn has_pose(self) -> bool {
        matches!(self, Outside | Tracking)
    }

    /// The state after `event`. An event that means nothing in this state changes nothing: a frame before the registration,
    /// a calibration while one is there.
    #[must_use]
    pub fn step(self, event: Event) -> Self {
        match event {
            Event::CalibrationWithdrawn => NotCalibrated,
            Event::Calibrated if self == NotCalibrated => NotRegistered,
            Event::RegistrationWithdrawn if self != NotCalibrated => NotRegistered,
            Event::Registered if self == NotRegistered => Stale,
            Event::Silence if LIVE.contains(&self) => Stale,
            Event::Frame(outcome) if LIVE.contains(&self) && OUTCOMES.contains(&outcome) => outcome,
            _ => self,
        }
    }
}

impl Event {
    /// Every event.
    fn all() -> impl Iterator<Item = Self> {
        let set_up = [
            Self::Calibrated,
            Self::CalibrationWithdrawn,
            Self::Registered,
            Self::RegistrationWithdrawn,
            Self::Silence,
        ];
        set_up.into_iter().chain(OUTCOMES.into_iter().map(Self::Frame))
    }

    fn words(self) -> String {
        match self {
            Self::Calibrated => "calibration accepted".to_owned(),
            Self::CalibrationWithdrawn => "calibration withdrawn".to_owned(),
            Self::Registered => "registration accepted".to_owned(),
            Self::RegistrationWithdrawn => "registration withdrawn".to_owned(),
            Self::Silence => "no frame in time".to_owned(),
            Self::Frame(status) => format!("frame: {}", status.words()),
        }
    }
}

/// The machine as a graph in the DOT language (`dot -Tsvg`): boxes publish a pose, ellipses a reason. Live states lead to one
/// another by their frames, which is drawn once, through a point, and not 132 times.
pub fn diagram() -> String {
    let mut text = "digraph tracker {\n    rankdir=LR;\n    frame [shape=point, xlabel=\"each frame\"];\n".to_owned();
    for (i, status) in Status::ALL.iter().enumerate() {
        let shape = if status.has_pose() { "box" } else { "ellipse" };
        let _ = writeln!(text, "    s{i} [label=\"{}\", shape={shape}];", status.words());
    }
    let place = |status: Status| Status::ALL.iter().position(|s| *s == status).unwrap_or(0);
    for from in Status::ALL {
        for event in Event::all() {
            let to = from.step(event);
            if to != from && !matches!(event, Event::Frame(_)) {
                let _ = writeln!(
                    text,
                    "    s{} -> s{} [label=\"{}\"];",
                    place(from),
                    place(to),
                    event.words()
                );
            }
        }
    }
    for from in LIVE {
        let _ = writeln!(text, "    s{} -> frame [arrowhead=none, style=dashed];", place(from));
    }
    for to in OUTCOMES {
        let _ = writeln!(text, "    frame -> s{} [label=\"{}\"];", place(to), to.words());
    }
    text + "}\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_event() -> impl Strategy<Value = Event> {
        prop::sample::select(Event::all().collect::<Vec<_>>())
    }

    proptest! {
        #[test]
        fn there_is_no_pose_without_calibration_registration_and_a_frame_since(events in prop::collection::vec(any_event(), 0..60)) {
            let (mut status, mut calibrated, mut registered, mut frame) = (Status::START, false, false, None);
            for event in events {
                status = status.step(event);
                match event {
                    Event::Calibrated => calibrated = true,
                    Event::CalibrationWithdrawn => (calibrated, registered, frame) = (false, false, None),
                    Event::Registered if calibrated => registered = true,
                    Event::RegistrationWithdrawn => (registered, frame) = (false, None),
                    Event::Silence => frame = None,
                    Event::Frame(outcome) if calibrated && registered => frame = Some(outcome),
                    _ => {}
                }
                let expected = match (calibrated, registered, frame) {
                    (false, ..) => NotCalibrated,
                    (_, false, _) => NotRegistered,
                    (_, _, None) => Stale,
                    (_, _, Some(outcome)) => outcome,
                };
                prop_assert_eq!(status, expected);
            }
        }
    }

    #[test]
    fn the_diagram_shows_every_state_and_only_steps_that_there_are() {
        let text = diagram();
        for status in Status::ALL {
            assert!(
                text.contains(&format!("label=\"{}\", shape", status.words())),
                "{status:?}"
            );
        }
        assert!(text.contains("s1 -> s2 [label=\"registration accepted\"]"));
        assert!(!text.contains("s0 -> s2"));
        assert_eq!(text.matches("shape=box").count(), 2);
    }
}
