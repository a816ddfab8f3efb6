//! Why there is no sight.

use std::fmt;

/// What was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// The translation of the tool's pose.
    Pose,
    /// The tool's tip.
    Tip,
    /// The tool's axis.
    Axis,
    /// The target's centre.
    Target,
    /// The target's radius.
    Radius,
    /// The entry.
    Entry,
    /// The stop distance.
    Stop,
    /// The sight's right and down.
    SightAxes,
    /// The threshold of the tip's distance from the planned way.
    Corridor,
    /// The threshold of the angle to the planned line.
    Align,
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pose => "pose of the tool",
            Self::Tip => "tip of the tool",
            Self::Axis => "axis of the tool",
            Self::Target => "centre of the target",
            Self::Radius => "radius of the target",
            Self::Entry => "entry",
            Self::Stop => "stop distance",
            Self::SightAxes => "right and down of the sight",
            Self::Corridor => "threshold of the corridor",
            Self::Align => "threshold of the angle",
        })
    }
}

/// Why an input was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refused {
    /// A number is NaN or infinite.
    #[error("{what}: {found} is not a finite number")]
    NotFinite {
        /// Which input.
        what: Input,
        /// The number found.
        found: f64,
    },
    /// A number is outside its domain; the lower end is excluded where it is zero, but for the stop distance.
    #[error("{what}: {found} is outside {} to {}", allowed[0], allowed[1])]
    OutOfRange {
        /// Which input.
        what: Input,
        /// The number found.
        found: f64,
        /// The least and the largest.
        allowed: [f64; 2],
    },
    /// Entry and target are the same place, so that there is no line.
    #[error("entry: {distance_mm} mm from the target's centre, a line needs at least {least_mm} mm")]
    EntryIsTarget {
        /// Their distance, mm.
        distance_mm: f64,
        /// The least distance, mm.
        least_mm: f64,
    },
    /// The sight's right and down are not perpendicular to each other and to the tool's axis.
    #[error("right and down of the sight: cosine {cosine} between two of right, down and the tool's axis, 0 is needed")]
    Skewed {
        /// The largest cosine between two of the three.
        cosine: f64,
    },
    /// The sight would be seen from the tip towards the handle, that is mirrored.
    #[error("right and down of the sight: mirrored, right x down must be the direction in which the tool advances")]
    Mirrored,
}

/// Why there is no sight. `R` is the reason of a pose that is lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoSight<R> {
    /// There is no valid pose.
    Lost(R),
    /// An input is unusable.
    Refused(Refused),
}

impl<R> From<Refused> for NoSight<R> {
    fn from(refused: Refused) -> Self {
        Self::Refused(refused)
    }
}

impl<R: fmt::Display> fmt::Display for NoSight<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost(reason) => write!(f, "no sight: {reason}"),
            Self::Refused(refused) => write!(f, "no sight: {refused}"),
        }
    }
}

impl<R: fmt::Debug + fmt::Display> std::error::Error for NoSight<R> {}
