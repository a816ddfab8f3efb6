//! What a client is told to do.

use std::fmt;

use crate::limits::Limits;
use crate::options::{Bx2Options, Markers, ReplyOption};
use crate::pose::UNIT_TOLERANCE;
use crate::rom::Rom;

const MS: i64 = 1_000_000;

/// How frames are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Poll {
    /// BX2: with the device's time, and a reason for each marker.
    Bx2,
    /// BX: single precision.
    Bx,
    /// TX: two decimals of a millimetre. Every device knows it.
    Tx,
}

impl Poll {
    /// What is tried next where the device does not know this one.
    pub(super) const fn simpler(self) -> Option<Self> {
        match self {
            Self::Bx2 => Some(Self::Bx),
            Self::Bx => Some(Self::Tx),
            Self::Tx => None,
        }
    }
}

impl fmt::Display for Poll {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bx2 => "BX2",
            Self::Bx => "BX",
            Self::Tx => "TX",
        })
    }
}

/// A tool whose definition is written to the device.
#[derive(Debug, Clone, PartialEq)]
pub struct Tool {
    /// What it is called here.
    pub name: String,
    /// Its definition, which was checked.
    pub rom: Rom,
    /// Whether it hardly moves (`S`), moves (`D`), or has buttons alone (`B`).
    pub priority: char,
}

/// What a client does.
#[derive(Debug, Clone, PartialEq)]
pub struct ClientRules {
    /// Tools to be loaded, at most [`crate::MOST_LOADED`].
    pub tools: Vec<Tool>,
    /// Whether tools that are plugged in are initialised and enabled too.
    pub wired: bool,
    /// The speed of a serial line after INIT, five digits of COMM; `None` on a network.
    pub comm: Option<String>,
    /// Whether commands have a CRC.
    pub crc: bool,
    /// How frames are asked for; `None` for the best that the device knows.
    pub poll: Option<Poll>,
    /// Which single markers are wanted. TX knows strays alone.
    pub markers: Markers,
    /// From one poll to the next, ns.
    pub poll_ns: i64,
    /// How long an answer may take, ns.
    pub answer_ns: i64,
    /// The same of INIT, PINIT and TSTART, ns.
    pub slow_ns: i64,
    /// How long the device must be silent before it is asked anew, ns.
    pub quiet_ns: i64,
    /// How long this silence is waited for, ns.
    pub quiet_limit_ns: i64,
    /// How often VER is asked before the connection is given up.
    pub most_tries: u32,
    /// How far the length of a quaternion may be off 1.
    pub tolerance: f64,
    /// How much a device may make the client hold.
    pub limits: Limits,
}

impl Default for ClientRules {
    /// No tools; a network; a poll each 5 ms; 1 s for an answer, 10 s for a slow one; silence of 200 ms, waited for for
    /// 3 s; 3 tries.
    fn default() -> Self {
        Self {
            tools: Vec::new(),
            wired: false,
            comm: None,
            crc: true,
            poll: None,
            markers: Markers::None,
            poll_ns: 5 * MS,
            answer_ns: 1000 * MS,
            slow_ns: 10_000 * MS,
            quiet_ns: 200 * MS,
            quiet_limit_ns: 3000 * MS,
            most_tries: 3,
            tolerance: UNIT_TOLERANCE,
            limits: Limits::DEFAULT,
        }
    }
}

impl ClientRules {
    /// BX2 with the markers that are wanted.
    pub(super) const fn bx2(&self) -> Bx2Options {
        Bx2Options {
            tools: true,
            markers: self.markers,
            buttons: false,
        }
    }

    /// BX with them. Statuses of tools are asked for: they say why a pose is missing.
    pub(super) fn bx(&self) -> ReplyOption {
        let markers = if self.markers.tools() { ReplyOption::MARKERS } else { 0 };
        ReplyOption(markers | self.tx().0 | ReplyOption::OUT_OF_VOLUME)
    }

    /// TX with strays. What is out of volume is not asked for: it would not be used.
    pub(super) const fn tx(&self) -> ReplyOption {
        let strays = if self.markers.strays() { ReplyOption::STRAYS } else { 0 };
        ReplyOption(ReplyOption::TRANSFORMS | ReplyOption::INFORMATION | strays)
    }
}
