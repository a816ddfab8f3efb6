//! What is counted and told of a device's clock, each thing once.

use super::quality::{Event, Reason};

/// So many steps within [`UNSTEADY_NS`] make a clock unsteady, for as long after the last of them.
const STEPS: usize = 4;
const UNSTEADY_NS: i64 = 10_000_000_000;

#[derive(Debug, Clone)]
pub(super) struct Told {
    /// Steps since the beginning.
    pub(super) steps: u64,
    /// Arrivals of the newest steps, the oldest first.
    newest: [Option<i64>; STEPS],
    unsteady_until_ns: Option<i64>,
    /// Frames that had the time of their arrival, by reason, and when the newest of each came.
    pub(super) arrivals: [u64; Reason::ALL.len()],
    given_ns: [Option<i64>; Reason::ALL.len()],
    /// A reason that did not come for so long is news again.
    forgotten_ns: i64,
}

impl Told {
    pub(super) fn new(forgotten_ns: i64) -> Self {
        Self {
            steps: 0,
            newest: [None; STEPS],
            unsteady_until_ns: None,
            arrivals: [0; Reason::ALL.len()],
            given_ns: [None; Reason::ALL.len()],
            forgotten_ns,
        }
    }

    /// Another connection was made: what was told is news again, as its peer may be another, whose steps are counted anew.
    pub(super) fn reconnected(&mut self) {
        *self = Self {
            steps: self.steps,
            arrivals: self.arrivals,
            ..Self::new(self.forgotten_ns)
        };
    }

    /// Counts a step; gives it where the clock is not unsteady by now.
    pub(super) fn step(&mut self, by_ns: i64, arrival_ns: i64) -> Option<Event> {
        self.steps += 1;
        self.newest.rotate_left(1);
        self.newest[STEPS - 1] = Some(arrival_ns);
        if self.newest[0].is_some_and(|first| arrival_ns.saturating_sub(first) <= UNSTEADY_NS) {
            self.unsteady_until_ns = Some(arrival_ns.saturating_add(UNSTEADY_NS));
        }
        (!self.is_unsteady(arrival_ns)).then_some(Event::Step { by_ns })
    }

    pub(super) fn is_unsteady(&self, arrival_ns: i64) -> bool {
        self.unsteady_until_ns.is_some_and(|until| arrival_ns < until)
    }

    /// Counts a frame that has the time of its arrival; gives the reason where it is news.
    pub(super) fn arrival(&mut self, reason: Reason, arrival_ns: i64) -> Option<Event> {
        let at = reason.index();
        self.arrivals[at] += 1;
        let before = self.given_ns[at].replace(arrival_ns);
        let is_news = before.is_none_or(|before| arrival_ns.saturating_sub(before) >= self.forgotten_ns);
        (is_news && !reason.passes()).then_some(Event::Arrival(reason))
    }
}
