//! What is said of a mapped stamp.

use std::fmt;

/// A device's stamp on the run's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub struct Mapped {
    /// When the frame was captured, nanoseconds on the run's clock. Never later than its arrival, and never earlier than that of the
    /// frame before, unless the arrivals themselves went back.
    pub capture_ns: i64,
    /// How far `capture_ns` may be from the capture plus the part of the least delay that was not stated, nanoseconds: at least 99 frames
    /// of 100 are nearer. `None` where nothing bounds it, which is so for every arrival.
    pub uncertain_ns: Option<i64>,
    /// How much earlier than `capture_ns` the frame may have been captured, nanoseconds, 0 for nothing known of it: the sum of steps back, as a
    /// queue on the peer's side that grew by as much looks the same, and what the frame is late by a law that its stamps
    /// keep no more.
    pub waited_ns: i64,
    /// What `capture_ns` rests on.
    pub quality: Quality,
    /// What a person must know and was not told yet.
    pub event: Option<Event>,
}

/// What a stamp rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quality {
    /// The device's stamp, by the law.
    Mapped,
    /// The arrival: the stamp says nothing that may be used.
    Arrival(Reason),
}

/// Why a frame has the time of its arrival.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// The stamp is 0: the device states none.
    NoStamp,
    /// The stamp is before 1970 or after 7 February 2106, the end of what OpenIGTLink can say.
    OutOfRange,
    /// The stamp is that of the frame before.
    Repeated,
    /// The stamp has stood still for half a second while frames kept coming.
    Frozen,
    /// The stamp is earlier than that of the frame before.
    Backwards,
    /// Stamps go on at less than half or more than twice the speed of the run's clock: another unit, or no clock.
    Rate,
    /// The arrival is earlier than that of the frame before: the run's clock was not read in order.
    ArrivalBackwards,
    /// Too few frames since the beginning, a step or a long silence.
    JustBegun,
    /// The stamp is ahead of the law: the device's clock was set forward, or the stamp is wrong.
    Ahead,
    /// By the law the frame would be older than the one before: the device's clock was set back.
    Behind,
    /// Nothing holds the law within [`super::Mapping::WIDEST_NS`].
    Vague,
    /// The device's clock steps again and again.
    Unsteady,
}

impl Reason {
    /// Every reason.
    pub const ALL: [Self; 12] = [
        Self::NoStamp,
        Self::OutOfRange,
        Self::Repeated,
        Self::Frozen,
        Self::Backwards,
        Self::Rate,
        Self::ArrivalBackwards,
        Self::JustBegun,
        Self::Ahead,
        Self::Behind,
        Self::Vague,
        Self::Unsteady,
    ];

    /// Whether it ends by itself or in a step, and is counted only.
    pub(super) fn passes(self) -> bool {
        matches!(self, Self::JustBegun | Self::Ahead | Self::Behind | Self::Backwards)
    }

    /// Its place in [`Reason::ALL`].
    pub(super) fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoStamp => "the device states no time",
            Self::OutOfRange => "the device's stamp is not between 1970 and 2106",
            Self::Repeated => "the device's stamp is that of the frame before",
            Self::Frozen => "the device's stamp stands still",
            Self::Backwards => "the device's stamp went back",
            Self::Rate => "the device's stamps do not go on at the speed of a clock; is their unit right?",
            Self::ArrivalBackwards => "the frame arrived before the one before it",
            Self::JustBegun => "too few frames yet",
            Self::Ahead => "the device's stamp is ahead of its own law",
            Self::Behind => "the device's stamp is behind its own law",
            Self::Vague => "the device's stamps hold no law",
            Self::Unsteady => "the device's clock steps again and again",
        })
    }
}

/// What happened to the device's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Event {
    /// It was set by so many nanoseconds against the run's clock: forward is positive. A least delay that grew looks the same as a clock
    /// that was set back, and is told as one.
    Step {
        /// By how much.
        by_ns: i64,
    },
    /// Frames have the time of their arrival, and for the last 20 s did not for this reason.
    Arrival(Reason),
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step { by_ns } => write!(f, "the device's clock was set by {:+.3} ms", crate::clock::ms(*by_ns)),
            Self::Arrival(reason) => write!(f, "frames have the time of their arrival: {reason}"),
        }
    }
}
