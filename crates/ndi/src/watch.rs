//! Numbers of frames: which is new, which was polled before, where the device counts otherwise.

use crate::frame::Frame;

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
    /// It is a later one.
    Next {
        /// So many between them were not polled.
        missed: u32,
        /// The number began again at 0.
        wrapped: bool,
    },
    /// The number is not near the last one, or goes back: the device counts otherwise, or is another one.
    Jump {
        /// The last number.
        from: u32,
        /// This one.
        to: u32,
    },
}

/// The last number of each kind of frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FrameWatch(Vec<(u32, u32)>);

impl FrameWatch {
    /// How this frame follows; it is the last one then. Frames of BX2 are told apart by their kind, those of TX and BX
    /// by their first tool.
    pub fn judge(&mut self, frame: &Frame) -> FrameStep {
        let Some(number) = frame.number else {
            return FrameStep::First;
        };
        let of_tools = || frame.tools.first().map_or(0, |sight| u32::from(sight.handle().0));
        let key = frame.kind.map_or_else(of_tools, |kind| {
            1 << 16 | u32::from(kind.0) << 8 | u32::from(frame.index)
        });
        match self.0.iter_mut().find(|(kept, _)| *kept == key) {
            Some((_, last)) => step(std::mem::replace(last, number), number),
            None => {
                self.0.truncate(MOST_KEPT - 1);
                self.0.push((key, number));
                FrameStep::First
            }
        }
    }

    /// Knows nothing any more: after a reset a device counts from anywhere.
    pub fn forget(&mut self) {
        self.0.clear();
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
