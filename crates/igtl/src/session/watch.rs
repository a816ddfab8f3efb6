//! What both sides watch: silence, messages that do not end, messages that are refused.

use super::{Action, Event, Notice, Reason};
use crate::malformed::{Malformed, Recovery};

/// So many refused messages one after the other close a connection.
const MOST_REFUSED: u32 = 3;

/// Time limits of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    /// From one whole message to the beginning of the next, ns; `None` for no limit.
    pub(crate) silent_ns: Option<i64>,
    /// How long a message may take, as far as ticks tell, whatever its length, ns.
    pub(crate) stuck_ns: i64,
    /// One that takes longer must come at this rate, bytes per second.
    pub(crate) least_rate: u64,
}

impl Bounds {
    /// Whether so many bytes in so long are too few.
    fn is_stuck(&self, come: u64, ns: i64) -> bool {
        let needed = i128::from(self.least_rate) * i128::from(ns) / 1_000_000_000;
        ns > self.stuck_ns && i128::from(come) < needed
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Watch {
    bounds: Bounds,
    heard_ns: i64,
    begun_ns: Option<i64>,
    refused: u32,
}

impl Watch {
    pub(crate) const fn new(bounds: Bounds, now_ns: i64) -> Self {
        Self {
            bounds,
            heard_ns: now_ns,
            begun_ns: None,
            refused: 0,
        }
    }

    /// What must be done about this event whatever else it is; a [`Action::Close`] stands last.
    pub(crate) fn step(&mut self, event: &Event<'_>, now_ns: i64) -> Option<Action> {
        match event {
            Event::Connected => {
                *self = Self::new(self.bounds, now_ns);
                None
            }
            Event::Received(_) => {
                self.heard(now_ns);
                self.refused = 0;
                None
            }
            Event::Refused(malformed) => Some(self.refused(malformed, now_ns)),
            Event::Tick { come } => self.tick(*come, now_ns),
            Event::Closed => None,
        }
    }

    fn heard(&mut self, now_ns: i64) {
        self.heard_ns = now_ns;
        self.begun_ns = None;
    }

    fn refused(&mut self, malformed: &Malformed, now_ns: i64) -> Action {
        self.heard(now_ns);
        self.refused += 1;
        match malformed.recovery {
            Recovery::Close => Action::Close(Reason::Malformed(malformed.clone())),
            Recovery::NextMessage if self.refused >= MOST_REFUSED => Action::Close(Reason::TooManyRefused {
                count: self.refused,
                last: malformed.clone(),
            }),
            Recovery::NextMessage => Action::Tell(Notice::Malformed(malformed.clone())),
        }
    }

    fn tick(&mut self, come: u64, now_ns: i64) -> Option<Action> {
        if come > 0 {
            let ns = now_ns.saturating_sub(*self.begun_ns.get_or_insert(now_ns));
            let is_stuck = self.bounds.is_stuck(come, ns);
            return is_stuck.then_some(Action::Close(Reason::Stuck { come, ns }));
        }
        self.begun_ns = None;
        let ns = now_ns.saturating_sub(self.heard_ns);
        let is_silent = self.bounds.silent_ns.is_some_and(|limit| ns > limit);
        is_silent.then_some(Action::Close(Reason::Silent { ns }))
    }
}
