//! What is said, as messages: poses, statuses, words.

use bus::message::{Lost, MarkerFrame, ToolPose, Workflow};
use geometry::{Marker, Reference};
use igtl::{Body, DeviceName, Matrix, Message, Metadata, Stamp, Status, TRANSFORM_STATUS, Text, Tool, ToolKind};

use crate::letter::Letter;
use crate::origin::Origin;
use crate::place::{in_ras, matrix};
use crate::standing::Standing;

/// In metadata: why a pose is none. Keys with `Status` in them become attributes of a node in 3D Slicer.
const WHY: &str = "TransformStatusReason";
/// In metadata: whether what is shown is of the present.
const SESSION: &str = "SessionStatus";
/// In metadata: what stands on everything that is shown of an unchecked registration.
const CHECK: &str = "CheckStatus";

/// `ToolToTracker`.
pub(crate) fn tool_marker() -> DeviceName {
    named("ToolToTracker")
}

/// `ReferenceToTracker`.
pub(crate) fn reference_marker() -> DeviceName {
    named("ReferenceToTracker")
}

/// A device of ours; its name is short and of ASCII.
pub(crate) fn named(name: &str) -> DeviceName {
    DeviceName::new(name).unwrap_or_default()
}

/// One tool: its device, its pose or why there is none, and what stands beside it.
#[derive(Debug, Clone)]
pub(crate) struct Told {
    pub(crate) device: DeviceName,
    pub(crate) pose: Result<Matrix, String>,
    pub(crate) stamp: Stamp,
    pub(crate) number: u32,
    pub(crate) metadata: Metadata,
    /// Until when the pose is young enough, ns on CLOCK_MONOTONIC.
    pub(crate) until_ns: Option<i64>,
}

/// A matrix that turns, scales and moves everything into one point: no pose. Some receivers take a matrix whatever its status says; of
/// the last one, or of none, they would draw the tool somewhere in the patient.
const NO_POSE: Matrix = Matrix {
    columns: [[0.0; 3]; 3],
    translation: [0.0; 3],
};

impl Told {
    /// The tool in the patient.
    pub(crate) fn tool(
        origin: Origin,
        standing: &Standing,
        sample: Option<&ToolPose>,
        workflow: Option<&Workflow>,
    ) -> Self {
        let pose = match standing {
            Standing::Valid(pose) => Ok(in_ras(pose)),
            other => Err(format!("{}: {}", other.word(origin.is_present()), other.why())),
        };
        let mut metadata = Metadata::EMPTY.with(SESSION, Text::new(origin.session()));
        if let (Some(sample), Ok(_)) = (sample, &pose) {
            metadata = metadata
                .with("PoseNumber", Text::new(&sample.seq.to_string()))
                .with("Registration", Text::new(&format!("{:016x}", sample.registration_id)));
            if let Some(mm) = sample.tip_95_mm() {
                metadata = metadata.with("TipError95Mm", Text::new(&format!("{mm:.2}")));
            }
        }
        if let Some(words) = workflow.and_then(marks) {
            metadata = metadata.with(CHECK, Text::new(&words));
        }
        Self {
            device: origin.tool(),
            pose,
            stamp: Stamp::NONE,
            // Counts on from the start, as the wire has 32 bits.
            number: sample.map_or(0, |sample| sample.seq as u32),
            metadata,
            until_ns: None,
        }
    }

    /// The two markers of a frame in the localizer's own frame, as they came; `why_not` where the frame is too old.
    pub(crate) fn markers(frame: &MarkerFrame, why_not: Option<&str>) -> [Self; 2] {
        let tool = frame.sight::<Marker>(MarkerFrame::TOOL);
        let tool = tool.map(|sight| sight.tracker_from_marker.map(|pose| matrix(&pose)));
        let reference = frame.sight::<Reference>(MarkerFrame::REFERENCE);
        let reference = reference.map(|sight| sight.tracker_from_marker.map(|pose| matrix(&pose)));
        let words = |lost: Lost| format!("LOST: {}", lost.words());
        [(tool_marker(), tool), (reference_marker(), reference)].map(|(device, sight)| Self {
            device,
            pose: match (sight, why_not) {
                (_, Some(why)) => Err(why.to_owned()),
                (Ok(pose), None) => pose.map_err(words),
                (Err(error), None) => Err(format!("REFUSED: {error}")),
            },
            stamp: Stamp::NONE,
            number: frame.seq as u32,
            metadata: Metadata::EMPTY,
            until_ns: None,
        })
    }

    /// With its time on the wire, and until when it is young enough.
    #[must_use]
    pub(crate) fn at(self, stamp: Stamp, until_ns: Option<i64>) -> Self {
        Self {
            stamp,
            until_ns,
            ..self
        }
    }

    fn status(&self) -> &'static str {
        if self.pose.is_ok() { "OK" } else { "MISSING" }
    }

    /// As a TRANSFORM. A pose that is none goes to clients of version 2 alone, with its status.
    pub(crate) fn transform(&self) -> Letter {
        let mut metadata = Metadata::EMPTY.with(TRANSFORM_STATUS, Text::new(self.status()));
        if let Err(why) = &self.pose {
            metadata = metadata.with(WHY, Text::new(why));
        }
        let metadata = self.metadata.entries().iter().fold(metadata, |metadata, entry| {
            metadata.with(&entry.key, entry.value.clone())
        });
        let pose = self.pose.as_ref().ok().copied();
        let letter = Letter::new(Message {
            stamp: self.stamp,
            number: self.number,
            metadata,
            ..Message::new(self.device, Body::Transform(pose.unwrap_or(NO_POSE)))
        });
        if pose.is_some() {
            letter.until(self.until_ns)
        } else {
            letter.not_to_one()
        }
    }
}

/// All tools of one moment as a TDATA; those without a pose are left out, as the protocol says, and told in the metadata.
pub(crate) fn tdata(all: Vec<Told>, origin: Origin) -> Letter {
    let seen = all.iter().filter(|told| told.pose.is_ok());
    let until_ns = seen.clone().filter_map(|told| told.until_ns).min();
    let is_empty = seen.count() == 0;
    let letter = Letter::made(move || tools(&all, origin));
    if is_empty {
        letter.not_to_one()
    } else {
        letter.until(until_ns)
    }
}

fn tools(all: &[Told], origin: Origin) -> Message<'static> {
    let mut metadata = Metadata::EMPTY.with(SESSION, Text::new(origin.session()));
    for told in all {
        metadata = metadata.with(&format!("{}Status", told.device), Text::new(told.status()));
        if let Err(why) = &told.pose {
            metadata = metadata.with(&format!("{}StatusReason", told.device), Text::new(why));
        }
    }
    let seen = all.iter().filter_map(|told| Some((told, told.pose.as_ref().ok()?)));
    let tools: Vec<Tool<Matrix>> = seen
        .map(|(told, pose)| Tool {
            name: told.device,
            kind: ToolKind::Six,
            pose: *pose,
        })
        .collect();
    Message {
        stamp: all.first().map_or(Stamp::NONE, |told| told.stamp),
        metadata,
        ..Message::new(named("Tracking"), Body::Tdata(tools))
    }
}

/// How the tool is, in words that every client reads.
pub(crate) fn words(standing: &Standing, origin: Origin, workflow: Option<&Workflow>) -> String {
    let mut words = standing.word(origin.is_present()).to_owned();
    if !standing.why().is_empty() {
        words += ": ";
        words += standing.why();
    }
    let rest = [origin.words().to_owned(), workflow.and_then(marks).unwrap_or_default()];
    for more in rest.iter().filter(|more| !more.is_empty()) {
        words += "; ";
        words += more;
    }
    words
}

/// What stands on everything that is shown.
fn marks(workflow: &Workflow) -> Option<String> {
    let mut words = Vec::new();
    if workflow.has(Workflow::RESEARCH) {
        words.push("RESEARCH");
    }
    words.extend(workflow.marks().into_iter().map(guidance::workflow::Mark::word));
    (!words.is_empty()).then(|| words.join(", "))
}

/// The heart-beat. Its code is that of "OK" for a pose of the present alone.
pub(crate) fn status(standing: &Standing, origin: Origin, words: &str, stamp: Stamp) -> Letter {
    let code = match standing {
        Standing::Valid(_) if origin.is_present() => Status::OK,
        Standing::Valid(_) | Standing::Waiting => NOT_READY,
        Standing::Stale => TIMED_OUT,
        Standing::Lost(_) => NOT_FOUND,
        Standing::Withheld(_) | Standing::Ended => DISABLED,
    };
    let status = Status {
        name: named(standing.word(origin.is_present())),
        ..Status::new(code, words)
    };
    Letter::new(Message {
        stamp,
        ..Message::new(named(SERVER), Body::Status(status))
    })
}

/// The device of what is said of the server itself.
pub(crate) const SERVER: &str = "Trocar";
/// Not found.
pub(crate) const NOT_FOUND: u16 = 4;
/// Busy.
pub(crate) const BUSY: u16 = 6;
const TIMED_OUT: u16 = 7;
/// It can never be said.
pub(crate) const CONFIGURATION: u16 = 10;
/// Not ready yet.
pub(crate) const NOT_READY: u16 = 13;
/// It may not be said now.
pub(crate) const DISABLED: u16 = 15;

/// What a client is told that asked for something that is not to be had.
pub(crate) fn refusal(code: u16, words: &str) -> Letter {
    Letter::new(Message::new(named(SERVER), Body::Status(Status::new(code, words))))
}

/// A line of words.
pub(crate) fn string(device: &str, words: &str, stamp: Stamp) -> Letter {
    // 64 KiB is the wire's; no line of ours is that long.
    let text: String = words.chars().take(4096).collect();
    Letter::new(Message {
        stamp,
        ..Message::new(named(device), Body::String(Text::new(&text)))
    })
}

/// How far the run has come, for a person.
pub(crate) fn stage(workflow: &Workflow, origin: Origin) -> String {
    let stage = workflow.stage().map_or("UNKNOWN", guidance::workflow::Stage::word);
    let mut words = stage.to_owned();
    for (flag, more) in [
        (Workflow::REJECTED, "EXAMINATION REJECTED"),
        (Workflow::CHECK_FAILED, "CHECK FAILED"),
        (Workflow::BUMPED, "REFERENCE BUMPED"),
    ] {
        if workflow.has(flag) {
            words += "; ";
            words += more;
        }
    }
    for more in [marks(workflow).unwrap_or_default(), origin.words().to_owned()] {
        if !more.is_empty() {
            words += "; ";
            words += &more;
        }
    }
    words
}
