//! Where the numbers of one kind of frame are, since the set-up.

use super::mark::{Mark, Run};
use super::past::Past;
use super::{FrameStep, step};
use crate::bx2::FrameKind;

/// So many frames that go back to where counting begins and on from there are no replies of before; so many behind a jump
/// say that it was none of a single frame. A second at 60 Hz.
const SURE: u32 = 60;
/// A number that stands still for so long while the device's time goes on, ns: each frame is polled more often than that.
const STANDS_NS: i64 = 500_000_000;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Counted {
    pub(super) key: u32,
    kind: Option<FrameKind>,
    /// Of this count, from the start or since it jumped.
    first: Mark,
    last: Mark,
    /// How many of it came.
    frames: u32,
    /// The count before it jumped, if that was more than a few frames.
    before: Option<Past>,
    /// The last of the count before the device was switched on anew, until it is passed.
    top: Option<Mark>,
    /// Frames a second, as they were before the set-up.
    least_per_s: f64,
    /// When the newest frame of this kind came, used or not.
    seen_ns: i64,
    /// The same of those that were not polled before.
    new_ns: i64,
    /// By the device's time, of the newest that stands.
    stood_ns: i64,
    back: Option<Run>,
}

impl Counted {
    /// The first frame of a tool or a kind since the set-up, behind what was before it.
    pub(super) fn new(key: u32, kind: Option<FrameKind>, first: Mark, past: Option<&Past>) -> Self {
        Self {
            key,
            kind,
            first,
            last: first,
            frames: 1,
            before: None,
            top: past.and_then(|past| past.top_of(&first)),
            least_per_s: past.map_or(0.0, |past| past.per_s),
            seen_ns: first.at_ns,
            new_ns: first.at_ns,
            stood_ns: i64::MIN,
            back: None,
        }
    }

    pub(super) fn judge(&mut self, mark: Mark) -> FrameStep {
        let seen_ns = std::mem::replace(&mut self.seen_ns, mark.at_ns);
        let is_later = match (self.last.device_ns, mark.device_ns) {
            (Some(last_ns), Some(ns)) => ns > last_ns,
            _ => mark.number.wrapping_sub(self.last.number) <= u32::MAX / 2,
        };
        let step = step(self.last.number, mark.number);
        if step == FrameStep::Same {
            self.back = None;
            return self.same(mark);
        }
        let new_ns = std::mem::replace(&mut self.new_ns, mark.at_ns);
        if matches!(step, FrameStep::Jump { .. }) && !is_later {
            let goes_on = |before: &Past| before.goes_on(&mark, seen_ns);
            let is_anew = mark.is_from_0(seen_ns, self.per_s()) || self.before.as_ref().is_some_and(goes_on);
            return self.goes_back(mark, is_anew);
        }
        if self.runs_ahead(mark, new_ns) {
            return self.goes_back(mark, false);
        }
        if matches!(step, FrameStep::Jump { .. }) {
            self.jumps(mark);
        }
        (self.last, self.back) = (mark, None);
        self.frames = self.frames.saturating_add(1);
        step
    }

    /// The number of the last one once more: it is polled again, or the number stands still.
    fn same(&mut self, mark: Mark) -> FrameStep {
        let (Some(last_ns), Some(ns)) = (self.last.device_ns, mark.device_ns) else {
            return FrameStep::Same;
        };
        if ns.saturating_sub(last_ns) < STANDS_NS || ns <= self.stood_ns {
            return FrameStep::Same;
        }
        self.stood_ns = ns;
        FrameStep::Stands { number: mark.number }
    }

    /// Whether a device that was switched on anew cannot have come so far yet: it is a reply of before it was.
    fn runs_ahead(&mut self, mark: Mark, new_ns: i64) -> bool {
        let per_s = self.per_s();
        self.top = self.top.filter(|top| !mark.is_after(top, per_s));
        let is_of_run = |run: Run| run.is_ahead_with(mark.number, self.last.number);
        self.top.is_some() && (self.back.is_some_and(is_of_run) || !mark.is_soon_after(&self.last, new_ns, per_s))
    }

    fn goes_back(&mut self, mark: Mark, is_anew: bool) -> FrameStep {
        let (from, to) = (self.last.number, mark.number);
        let Some(run) = Run::with(self.back, to, is_anew) else {
            return FrameStep::Same;
        };
        self.back = Some(run);
        let in_a_row = run.count;
        match run.is_anew && in_a_row >= SURE {
            true => FrameStep::Anew { frames: in_a_row },
            false => FrameStep::Back { from, to, in_a_row },
        }
    }

    /// Another count begins. What the old one was is kept, unless it was one odd frame or a few.
    fn jumps(&mut self, mark: Mark) {
        if self.frames >= SURE || self.before.is_none() {
            self.before = Some(self.as_past());
        }
        (self.first, self.frames) = (mark, 0);
    }

    fn per_s(&self) -> f64 {
        self.last.per_s(&self.first).max(self.least_per_s)
    }

    fn as_past(&self) -> Past {
        Past {
            kind: self.kind,
            last: self.last,
            top: self.top,
            per_s: self.per_s(),
            seen_ns: self.seen_ns,
            back: None,
        }
    }

    /// What is known of it behind a set-up: the count that it is sure of.
    pub(super) fn past(self) -> Past {
        let own = self.as_past();
        match self.before {
            Some(before) if self.frames < SURE => Past {
                seen_ns: self.seen_ns,
                ..before
            },
            _ => own,
        }
    }
}
