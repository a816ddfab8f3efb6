//! Where the numbers of one kind of frame were before the set-up.
//!
//! Replies that somebody between keeps, and gives again over another connection, have numbers and times that were there
//! already. A device that was switched on anew has had no more time to count than has gone by since its last frame came;
//! any other number that is not a later one is refused until it passes the last. Nothing but that tells such a device from
//! replies of its first seconds.

use super::FrameStep;
use super::mark::{Mark, Run};
use crate::bx2::FrameKind;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Past {
    pub(super) kind: Option<FrameKind>,
    pub(super) last: Mark,
    /// The last of the count before the device was switched on anew, until it is passed: what is of before has numbers up to it.
    pub(super) top: Option<Mark>,
    /// Frames a second.
    pub(super) per_s: f64,
    /// When the newest frame of this kind came, used or not.
    pub(super) seen_ns: i64,
    pub(super) back: Option<Run>,
}

impl Past {
    /// How the first frame of a tool or a kind follows.
    pub(super) fn judge(&mut self, mark: Mark) -> FrameStep {
        let (from, to) = (self.last.number, mark.number);
        let seen_ns = std::mem::replace(&mut self.seen_ns, mark.at_ns);
        if self.goes_on(&mark, seen_ns) {
            return FrameStep::First;
        }
        if (to, mark.device_ns) == (from, self.last.device_ns) {
            return FrameStep::Same;
        }
        if mark.is_from_0(seen_ns, self.per_s) {
            self.begins_anew(mark);
            return FrameStep::Restarted { from, to };
        }
        let Some(run) = Run::with(self.back, to, false) else {
            return FrameStep::Same;
        };
        self.back = Some(run);
        let in_a_row = run.count;
        FrameStep::Back { from, to, in_a_row }
    }

    /// Whether the count goes on with this one.
    pub(super) fn goes_on(&self, mark: &Mark, seen_ns: i64) -> bool {
        let is_soon = || mark.is_soon_after(&self.last, seen_ns, self.per_s);
        mark.is_after(&self.last, self.per_s) && (self.top_of(mark).is_none() || is_soon())
    }

    /// What a count that has come to this one has yet to pass.
    pub(super) fn top_of(&self, mark: &Mark) -> Option<Mark> {
        self.top.filter(|top| !mark.is_after(top, self.per_s))
    }

    fn begins_anew(&mut self, mark: Mark) {
        let last = self.last;
        self.top = self.top_of(&last).or(Some(last));
        // Other tools of the same reply follow this one.
        self.last = Mark {
            number: mark.number.wrapping_sub(1),
            device_ns: mark.device_ns.map(|ns| ns.saturating_sub(1)),
            ..mark
        };
    }

    /// Takes the place of what it was, where it is later: another tool of the same count may be behind.
    pub(super) fn gone_on(&mut self, newer: Self) {
        if newer.last.is_after(&self.last, self.per_s) {
            *self = newer;
        } else {
            self.seen_ns = self.seen_ns.max(newer.seen_ns);
        }
    }
}
