//! Numbers of frames: which is new, which was polled before, which is of before, where the device counts otherwise.

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
    /// The number is not near the last one, and yet the frame is a later one, by the device's time or, where it has none,
    /// by its number: the device counts otherwise.
    Jump {
        /// The last number.
        from: u32,
        /// This one.
        to: u32,
    },
    /// Nothing says that it is a later one: its number goes back, and so does its time, if it has one. It may be a reply
    /// of before, and is not the last one then; or the device has begun to count anew.
    Back {
        /// The last number.
        from: u32,
        /// This one.
        to: u32,
        /// So many frames one after the other, this one included, went back and on from there.
        in_a_row: u32,
    },
}

/// The last number of each kind of frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FrameWatch(Vec<Counted>);

/// Where the numbers of one kind of frame are.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Counted {
    key: u32,
    last: u32,
    /// When the last one was taken, by the device.
    device_ns: Option<i64>,
    /// The last number of those that went back, and how many of them there are.
    back: Option<(u32, u32)>,
}

impl FrameWatch {
    /// How this frame follows; it is the last one then, unless it goes back. Frames of BX2 are told apart by their kind,
    /// those of TX and BX by the first of their tools that has their number.
    pub fn judge(&mut self, frame: &Frame) -> FrameStep {
        let Some(number) = frame.number else {
            return FrameStep::First;
        };
        let of_tools = || frame.tools.first().map_or(0, |sight| u32::from(sight.handle().0));
        let key = frame.kind.map_or_else(of_tools, |kind| {
            1 << 16 | u32::from(kind.0) << 8 | u32::from(frame.index)
        });
        match self.0.iter_mut().find(|counted| counted.key == key) {
            Some(counted) => counted.judge(number, frame.device_ns),
            None => {
                self.0.truncate(MOST_KEPT - 1);
                self.0.push(Counted {
                    key,
                    last: number,
                    device_ns: frame.device_ns,
                    back: None,
                });
                FrameStep::First
            }
        }
    }

    /// Knows nothing any more: after a reset a device counts from anywhere.
    pub fn forget(&mut self) {
        self.0.clear();
    }
}

impl Counted {
    fn judge(&mut self, number: u32, device_ns: Option<i64>) -> FrameStep {
        let is_later = match (self.device_ns, device_ns) {
            (Some(last_ns), Some(ns)) => ns > last_ns,
            _ => number.wrapping_sub(self.last) <= u32::MAX / 2,
        };
        match step(self.last, number) {
            FrameStep::Jump { from, to } if !is_later => match self.goes_back(number) {
                Some(in_a_row) => FrameStep::Back { from, to, in_a_row },
                None => FrameStep::Same,
            },
            step => {
                self.back = None;
                (self.last, self.device_ns) = (number, device_ns);
                step
            }
        }
    }

    /// The how manyth this one is that goes back and on from there; `None` where it was polled before.
    fn goes_back(&mut self, number: u32) -> Option<u32> {
        let in_a_row = match self.back.map(|(last, count)| (step(last, number), count)) {
            Some((FrameStep::Same, _)) => return None,
            Some((FrameStep::Next { .. }, count)) => count.saturating_add(1),
            _ => 1,
        };
        self.back = Some((number, in_a_row));
        Some(in_a_row)
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
