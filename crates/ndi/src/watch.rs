//! Numbers of frames: which is new, which was polled before, which is of before, where the device counts otherwise.
//!
//! Times are ns of any clock here that does not go back.

mod counted;
mod mark;
mod past;

use crate::frame::Frame;
use counted::Counted;
use mark::Mark;
use past::Past;

/// Frames that a device may have taken between two polls; a larger step is a jump. Some four minutes at 60 Hz.
const MOST_MISSED: u32 = 1 << 14;
/// Counters that are kept: one for each kind of frame, or for each tool.
const MOST_KEPT: usize = 300;

/// How a frame follows the last one of its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameStep {
    /// It is the first, or has no number.
    First,
    /// It is the same: the device has taken none since the last poll.
    Same,
    /// It has the number of the last one, and by the device's time it was taken half a second later or more: one of the
    /// two is wrong, and nothing says that anything was measured since.
    Stands {
        /// The number.
        number: u32,
    },
    /// It is a later one.
    Next {
        /// So many between them were not polled.
        missed: u32,
        /// The number began again at 0.
        wrapped: bool,
    },
    /// The number is not near the last one, and yet the frame is a later one, by the device's time or, where it has none,
    /// by its number: the device counts otherwise.
    Jump {
        /// The last number.
        from: u32,
        /// This one.
        to: u32,
    },
    /// It is the first since a set-up, and its number is one that a device has that was switched on since the last frame.
    Restarted {
        /// The last number.
        from: u32,
        /// This one.
        to: u32,
    },
    /// Nothing says that it is a later one: its number goes back, and so does its time, if it has one. It may be a reply
    /// of before, and is not the last one then.
    Back {
        /// The last number.
        from: u32,
        /// This one.
        to: u32,
        /// So many frames one after the other, this one included, went back and on from there.
        in_a_row: u32,
    },
    /// So many frames one after the other went back and on from there, to begin with to 0 or to what came before a jump:
    /// the device counts anew.
    Anew {
        /// How many.
        frames: u32,
    },
}

/// The last number of each kind of frame, and of before the set-up.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameWatch {
    counted: Vec<Counted>,
    past: Vec<Past>,
}

impl FrameWatch {
    /// How this frame follows that came at `now_ns`; it is the last one then, unless it stands or goes back. Frames of BX2
    /// are told apart by their kind, those of TX and BX by the first of their tools that has their number.
    pub fn judge(&mut self, frame: &Frame, now_ns: i64) -> FrameStep {
        let Some(number) = frame.number else {
            return FrameStep::First;
        };
        let mark = Mark {
            number,
            device_ns: frame.device_ns,
            at_ns: now_ns,
        };
        let of_tools = || frame.tools.first().map_or(0, |sight| u32::from(sight.handle().0));
        let key = frame.kind.map_or_else(of_tools, |kind| {
            1 << 16 | u32::from(kind.0) << 8 | u32::from(frame.index)
        });
        if let Some(counted) = self.counted.iter_mut().find(|counted| counted.key == key) {
            return counted.judge(mark);
        }
        // Handles may be others than before the set-up.
        let mut past = self.past.iter_mut().find(|past| past.kind == frame.kind);
        if past.is_some() && number == 0 && frame.is_empty() {
            // What TX and BX give until something is measured: it is no count that began.
            return FrameStep::Same;
        }
        let step = past.as_mut().map_or(FrameStep::First, |past| past.judge(mark));
        if matches!(step, FrameStep::First | FrameStep::Restarted { .. }) {
            let counted = Counted::new(key, frame.kind, mark, past.as_deref());
            self.counted.truncate(MOST_KEPT - 1);
            self.counted.push(counted);
        }
        step
    }

    /// The device is set up again, on this connection or on another: what comes is held against what came, as replies of
    /// before may be given over another connection too.
    pub fn set_up(&mut self) {
        for counted in self.counted.drain(..) {
            let newer = counted.past();
            match self.past.iter_mut().find(|past| past.kind == newer.kind) {
                Some(past) => past.gone_on(newer),
                None => self.past.push(newer),
            }
        }
        self.past.truncate(MOST_KEPT);
    }

    /// Knows nothing any more: a device that has said that it was reset counts from anywhere.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

fn step(from: u32, to: u32) -> FrameStep {
    match to.wrapping_sub(from) {
        0 => FrameStep::Same,
        by if by <= MOST_MISSED => FrameStep::Next {
            missed: by - 1,
            wrapped: to < from,
        },
        _ => FrameStep::Jump { from, to },
    }
}
