//! What both sides watch: silence, messages that do not end, messages that are refused.

use super::{Action, Event, Notice, Reason};
use crate::malformed::{Malformed, Recovery};

/// So many refused messages one after the other close a connection.
const MOST_REFUSED: u32 = 3;

/// Time limits of a connection, ns; `None` for none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    /// From one whole message to the next.
    pub(crate) silent_ns: Option<i64>,
    /// From the first byte of a message, as far as ticks tell, to its last.
    pub(crate) stuck_ns: i64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Watch {
    bounds: Bounds,
    heard_ns: i64,
    within_since_ns: Option<i64>,
    refused: u32,
}

impl Watch {
    pub(crate) const fn new(bounds: Bounds, now_ns: i64) -> Self {
        Self {
            bounds,
            heard_ns: now_ns,
            within_since_ns: None,
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
            Event::Tick { within } => self.tick(*within, now_ns),
        }
    }

    fn heard(&mut self, now_ns: i64) {
        self.heard_ns = now_ns;
        self.within_since_ns = None;
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

    fn tick(&mut self, within: bool, now_ns: i64) -> Option<Action> {
        if within {
            let since = *self.within_since_ns.get_or_insert(now_ns);
            let ns = now_ns.saturating_sub(since);
            if ns > self.bounds.stuck_ns {
                return Some(Action::Close(Reason::Stuck { ns }));
            }
        } else {
            self.within_since_ns = None;
        }
        let ns = now_ns.saturating_sub(self.heard_ns);
        let is_silent = self.bounds.silent_ns.is_some_and(|limit| ns > limit);
        is_silent.then_some(Action::Close(Reason::Silent { ns }))
    }
}
