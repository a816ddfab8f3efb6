//! What an association brought, for a person and for who inspects it.

use std::fmt;
use std::path::PathBuf;

use super::uid::Uid;

/// How an association ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// The peer asked for its release between two messages.
    Released,
    /// It broke off, here or there; why.
    BrokenOff(String),
    /// This process was asked to stop.
    Stopped,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Released => write!(f, "ended in order"),
            Self::BrokenOff(why) => write!(f, "broken off: {why}"),
            Self::Stopped => write!(f, "broken off: this program was asked to stop"),
        }
    }
}

/// What came of one series.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Came {
    /// StudyInstanceUID and SeriesInstanceUID.
    pub name: [Uid; 2],
    /// The folder in which it lies.
    pub path: PathBuf,
    /// Whether it may be an examination: CT, Enhanced CT.
    pub is_slices: bool,
    /// Instances that are new.
    pub stored: u64,
    /// Instances that were there already, byte for byte.
    pub same: u64,
    /// Instances that were refused.
    pub refused: u64,
    /// Whether the folder is one of those that are incomplete.
    pub is_hidden: bool,
    /// Why not all of it is kept; `None`: all that came is, and the series has its name.
    pub lacking: Option<String>,
}

/// What an association brought.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// How it ended.
    pub ended: Ended,
    /// Verifications that were answered.
    pub echoes: u64,
    /// Instances that the peer began to send.
    pub asked: u64,
    /// Those that were refused, or that broke off.
    pub refused: u64,
    /// Bytes of data sets.
    pub bytes: u64,
    /// Each series of which something came, in the order of its names.
    pub series: Vec<Came>,
}

impl Outcome {
    /// Whether all that was sent is kept: it ended in order, nothing was refused, and each series has its name.
    pub fn is_kept(&self) -> bool {
        self.ended == Ended::Released && self.refused == 0 && self.series.iter().all(|came| came.lacking.is_none())
    }

    /// Instances that are new.
    pub fn stored(&self) -> u64 {
        self.series.iter().map(|came| came.stored).sum()
    }

    /// Instances that were there already.
    pub fn same(&self) -> u64 {
        self.series.iter().map(|came| came.same).sum()
    }
}
