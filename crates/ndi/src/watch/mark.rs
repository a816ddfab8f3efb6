//! Where a count stood, and how far it may have gone since.

use super::{FrameStep, step};

/// Frames a second of a device of which too few have come to know it.
const PER_S: f64 = 60.0;
/// So many are enough, in a second or more.
const ENOUGH: u32 = 30;
/// How much faster it may count than it did while it was looked at.
const FASTER: f64 = 1.25;
/// Frames that it may be ahead beside that: a reply waits until it is polled.
const SLACK: f64 = 10.0;

/// A frame's number with its times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Mark {
    pub(super) number: u32,
    /// When it was taken, by the device.
    pub(super) device_ns: Option<i64>,
    /// When it came.
    pub(super) at_ns: i64,
}

impl Mark {
    /// Frames a second from `first` on to this one, as far as they can be known.
    pub(super) fn per_s(&self, first: &Self) -> f64 {
        let frames = self.number.wrapping_sub(first.number);
        let s = self.at_ns.saturating_sub(first.at_ns) as f64 / 1e9;
        match s >= 1.0 && frames >= ENOUGH {
            true => f64::from(frames) / s,
            false => PER_S,
        }
    }

    /// Whether this one is later than `last`: by its time or, where the device's clock was set back or it has none, by its number.
    pub(super) fn is_after(&self, last: &Self, per_s: f64) -> bool {
        match (last.device_ns, self.device_ns) {
            (Some(last_ns), Some(ns)) => ns > last_ns || self.is_soon_after(last, last.at_ns, per_s),
            _ => self.is_ahead_of(last),
        }
    }

    /// Whether its number is ahead of that of `last`, and by no more frames than a device may have taken since `since_ns`.
    pub(super) fn is_soon_after(&self, last: &Self, since_ns: i64, per_s: f64) -> bool {
        let ahead = self.number.wrapping_sub(last.number);
        self.is_ahead_of(last) && may_be_taken(ahead, self.at_ns.saturating_sub(since_ns), per_s)
    }

    /// Whether it is a number that a device has that began to count since `since_ns`.
    pub(super) fn is_from_0(&self, since_ns: i64, per_s: f64) -> bool {
        may_be_taken(self.number, self.at_ns.saturating_sub(since_ns), per_s)
    }

    fn is_ahead_of(&self, last: &Self) -> bool {
        (1..=u32::MAX / 2).contains(&self.number.wrapping_sub(last.number))
    }
}

/// Whether a device that takes `per_s` frames a second may have taken so many in `ns`.
fn may_be_taken(frames: u32, ns: i64, per_s: f64) -> bool {
    f64::from(frames) <= ns.max(0) as f64 / 1e9 * per_s * FASTER + SLACK
}

/// Frames one after the other that are not used, and go on from each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    last: u32,
    pub(super) count: u32,
    /// It began where a device does that counts anew.
    pub(super) is_anew: bool,
}

impl Run {
    /// The run with this frame, which goes on with it or begins another one, of which `is_anew` holds; `None` where it was
    /// polled before.
    pub(super) fn with(run: Option<Self>, number: u32, is_anew: bool) -> Option<Self> {
        match run.map(|run| (step(run.last, number), run)) {
            Some((FrameStep::Same, _)) => None,
            Some((FrameStep::Next { .. }, run)) => Some(Self {
                last: number,
                count: run.count.saturating_add(1),
                ..run
            }),
            _ => Some(Self {
                last: number,
                count: 1,
                is_anew,
            }),
        }
    }

    /// Whether it is one that ran ahead of `last`, and this number is of it.
    pub(super) fn is_ahead_with(&self, number: u32, last: u32) -> bool {
        let is_ahead = self.last.wrapping_sub(last) <= u32::MAX / 2;
        is_ahead && matches!(step(self.last, number), FrameStep::Same | FrameStep::Next { .. })
    }
}
