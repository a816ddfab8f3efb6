//! Why a tool or a marker has no place that may be used.

use std::fmt;

use crate::pose::PoseError;

/// The one word for every status that a device states, and for what it sends and nobody can use.
///
/// Only [`Why::Valid`] goes with a pose or a place that may be used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Why {
    /// It was seen, and nothing is said against it.
    Valid,
    /// Not seen, without a reason.
    Missing,
    /// Outside the volume that the device was characterised in.
    OutOfVolume,
    /// Partly outside it.
    PartlyOutOfVolume,
    /// The mean of fewer poses than was asked for.
    PartlyAveraged,
    /// Too few markers are seen.
    TooFewMarkers,
    /// Infrared light of something else.
    Interference,
    /// The markers that are seen do not fit the tool's definition.
    BadFit,
    /// More data than the device can hold.
    BufferLimit,
    /// More computing than the device can do.
    AlgorithmLimit,
    /// The device is behind.
    FellBehind,
    /// Its sensors do not agree on the time.
    OutOfSync,
    /// The device failed.
    ProcessingError,
    /// The tool is known and not tracked.
    Disabled,
    /// The tool was unplugged, or its definition is not there.
    Unplugged,
    /// The tool is there and was not initialised.
    NotInitialized,
    /// The device took no tools of this kind in this frame: nothing is known of it.
    NotInFrame,
    /// A marker seen at too steep an angle.
    SteepAngle,
    /// A marker too far from where the tool's definition has it.
    MarkerError,
    /// A stray that may be the chance meeting of two rays.
    Phantom,
    /// A marker that is too bright.
    Saturated,
    /// The same, outside the volume.
    SaturatedOutOfVolume,
    /// The device calls it valid, and its numbers cannot be used.
    Refused(PoseError),
    /// A status that is not known here.
    Unknown {
        /// Which.
        field: &'static str,
        /// All of it.
        code: u32,
    },
}

impl Why {
    /// Whether a pose or a place may be used.
    pub fn is_valid(self) -> bool {
        self == Self::Valid
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Valid => "valid",
            Self::Missing => "missing",
            Self::OutOfVolume => "out of volume",
            Self::PartlyOutOfVolume => "partly out of volume",
            Self::PartlyAveraged => "partly averaged",
            Self::TooFewMarkers => "too few markers",
            Self::Interference => "interference",
            Self::BadFit => "bad fit",
            Self::BufferLimit => "too much data",
            Self::AlgorithmLimit => "too much to compute",
            Self::FellBehind => "the device is behind",
            Self::OutOfSync => "sensors out of step",
            Self::ProcessingError => "processing error",
            Self::Disabled => "disabled",
            Self::Unplugged => "unplugged",
            Self::NotInitialized => "not initialised",
            Self::NotInFrame => "not in this frame",
            Self::SteepAngle => "seen too steeply",
            Self::MarkerError => "marker off its place",
            Self::Phantom => "possible phantom",
            Self::Saturated => "saturated",
            Self::SaturatedOutOfVolume => "saturated, out of volume",
            Self::Refused(_) => "refused",
            Self::Unknown { .. } => "unknown status",
        }
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(error) => write!(f, "refused: {error}"),
            Self::Unknown { field, code } => write!(f, "{field} {code:#x} is not known"),
            other => f.write_str(other.words()),
        }
    }
}
