//! Whether this process itself stood still: what came meanwhile lies where it came, and nobody saw when.

use bus::message::CaptureClock;

use crate::clocks::Captured;

/// Between two looks at the connection no more goes by unless this process stood still, ns: it looks up each 20 ms.
const MOST_NS: i64 = 70_000_000;
/// Frames that came in one piece are put a nanosecond apart: those of before the standstill end before this, ns.
const BEHIND_NS: i64 = 1_000;

/// The looks at the connection.
#[derive(Debug, Default)]
pub(crate) struct Attention {
    /// When it was looked at last; `None`: not yet.
    looked_ns: Option<i64>,
    /// What is read now may have come at any time since then, ns; counts up by the frames of it.
    since_ns: Option<i64>,
    /// The last read found as much as there was room for: there may be more of then.
    is_full: bool,
}

impl Attention {
    /// The connection was looked at; `is_full`: there was as much as could be read at once.
    pub(crate) fn looked(&mut self, now_ns: i64, is_full: bool) {
        let before_ns = self.looked_ns.replace(now_ns);
        if !std::mem::replace(&mut self.is_full, is_full) {
            self.since_ns = None;
        }
        if let Some(before_ns) = before_ns.filter(|before_ns| now_ns.saturating_sub(*before_ns) > MOST_NS) {
            // Of several standstills the first one: what came in it may be there still.
            self.since_ns.get_or_insert(before_ns.saturating_add(BEHIND_NS));
        }
    }

    /// The capture of a frame that was just read. Where nothing but its arrival says when it was, it is as old as the standstill.
    pub(crate) fn judged(&mut self, captured: Captured) -> Captured {
        let Some(since_ns) = &mut self.since_ns else {
            return captured;
        };
        if captured.clock != CaptureClock::Arrival || captured.at_ns <= *since_ns {
            return captured;
        }
        // No two frames are of one time.
        *since_ns += 1;
        Captured {
            at_ns: *since_ns,
            ..captured
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn captured(at_ms: i64, clock: CaptureClock) -> Captured {
        Captured {
            at_ns: at_ms * MS,
            uncertain_ns: 0,
            clock,
            waited_ns: 0,
        }
    }

    /// Frames of a second and a half were all captured at the resume.
    #[test]
    fn what_came_while_this_process_stood_still_is_as_old_as_that() {
        let mut attention = Attention::default();
        let arrived = |attention: &mut Attention, at_ms| attention.judged(captured(at_ms, CaptureClock::Arrival)).at_ns;
        for look in [0, 20, 40] {
            attention.looked(look * MS, false);
            assert_eq!(arrived(&mut attention, look), look * MS);
        }
        attention.looked(1540 * MS, true);
        assert_eq!(arrived(&mut attention, 1540), 40 * MS + BEHIND_NS + 1);
        assert_eq!(
            arrived(&mut attention, 1540),
            40 * MS + BEHIND_NS + 2,
            "no two frames are of one time"
        );
        // What has a time of its own needs none of this.
        let stamped = captured(1000, CaptureClock::Mapped);
        assert_eq!(attention.judged(stamped), stamped);
        // There was more than could be read at once.
        attention.looked(1541 * MS, false);
        assert_eq!(arrived(&mut attention, 1541), 40 * MS + BEHIND_NS + 3);
        attention.looked(1550 * MS, false);
        assert_eq!(arrived(&mut attention, 1550), 1550 * MS);
    }
}
