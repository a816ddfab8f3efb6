//! What a sender says of a tool beside its pose: metadata of version 2, in the words of PLUS.
//!
//! The keys are `TransformStatus` of a TRANSFORM or POSITION, and `<tool>Status` of a TDATA, whose tool names are cut
//! to 20 bytes while these keys are not. A sender that says nothing has said nothing: it is for the receiver to know
//! whether that means a good pose.

use crate::metadata::Metadata;

/// The key of the status of a TRANSFORM or a POSITION.
pub const TRANSFORM_STATUS: &str = "TransformStatus";

/// What is said of a tool.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ToolStatus {
    /// Nothing, or in a message of version 1.
    Absent,
    /// `OK`: it is seen and its pose is good.
    Ok,
    /// `MISSING`.
    Missing,
    /// `OUT_OF_VIEW`.
    OutOfView,
    /// `OUT_OF_VOLUME`.
    OutOfVolume,
    /// `SWITCH1_IS_ON` to `SWITCH3_IS_ON`: a button is pressed.
    SwitchOn(u8),
    /// `REQ_TIMEOUT`: the tracker did not answer.
    TimedOut,
    /// `INVALID`.
    Invalid,
    /// `PATH_NOT_FOUND`: no chain of transforms leads from one frame to the other.
    PathNotFound,
    /// `UNKNOWN`.
    Unknown,
    /// Anything else, letter by letter, cut to 64 characters: `ok` is not `OK`. It is no good pose.
    Foreign(String),
}

const WORDS: [(&str, ToolStatus); 11] = [
    ("OK", ToolStatus::Ok),
    ("MISSING", ToolStatus::Missing),
    ("OUT_OF_VIEW", ToolStatus::OutOfView),
    ("OUT_OF_VOLUME", ToolStatus::OutOfVolume),
    ("SWITCH1_IS_ON", ToolStatus::SwitchOn(1)),
    ("SWITCH2_IS_ON", ToolStatus::SwitchOn(2)),
    ("SWITCH3_IS_ON", ToolStatus::SwitchOn(3)),
    ("REQ_TIMEOUT", ToolStatus::TimedOut),
    ("INVALID", ToolStatus::Invalid),
    ("PATH_NOT_FOUND", ToolStatus::PathNotFound),
    ("UNKNOWN", ToolStatus::Unknown),
];

impl ToolStatus {
    /// Of a TRANSFORM or POSITION.
    pub fn of_transform(metadata: &Metadata) -> Self {
        Self::of(metadata, TRANSFORM_STATUS)
    }

    /// Of a tool of a TDATA or QTDATA, by its whole name.
    pub fn of_tool(metadata: &Metadata, name: &str) -> Self {
        Self::of(metadata, &format!("{name}Status"))
    }

    fn of(metadata: &Metadata, key: &str) -> Self {
        let Some(text) = metadata.get(key) else {
            return Self::Absent;
        };
        let known = WORDS.iter().find(|(word, _)| text.bytes == word.as_bytes());
        known.map_or_else(
            || Self::Foreign(text.to_string().chars().take(64).collect()),
            |(_, status)| status.clone(),
        )
    }

    /// As it stands on the wire; `None` where nothing does.
    pub fn word(&self) -> Option<&str> {
        if let Self::Foreign(text) = self {
            return Some(text);
        }
        WORDS.iter().find(|(_, status)| status == self).map(|(word, _)| *word)
    }

    /// Whether the sender says that the pose is good.
    pub fn is_ok(&self) -> bool {
        *self == Self::Ok
    }
}
