//! Whether tool and patient are ever in one frame.
//!
//! A peer that gives each message a stamp of its own is understood, and shows nothing of the tool in the patient: that has to be said.

use crate::driver::Frame;

/// A pose that came within this is of now, ns.
const NOW_NS: i64 = 500_000_000;
/// For so long both come, and never in one frame, before it is said, ns.
const SAID_AFTER_NS: i64 = 1_000_000_000;

/// What has gone out.
#[derive(Debug, Clone)]
pub(super) struct Together {
    /// Markers that are looked for, and when each had a pose last, ns.
    seen_ns: Vec<(u32, Option<i64>)>,
    /// Since when all have poses, and no frame has all of them, ns.
    since_ns: Option<i64>,
}

impl Together {
    pub(super) fn new(wanted: &[u32]) -> Self {
        Self {
            seen_ns: wanted.iter().map(|marker| (*marker, None)).collect(),
            since_ns: None,
        }
    }

    /// A frame goes out at `now_ns`; whether all markers have had poses for a while, and never in one frame.
    pub(super) fn are_apart(&mut self, frame: &Frame, now_ns: i64) -> bool {
        let has = |marker: u32| {
            frame
                .seen
                .iter()
                .any(|seen| seen.marker == marker && seen.outcome.is_ok())
        };
        for (marker, seen_ns) in &mut self.seen_ns {
            if has(*marker) {
                *seen_ns = Some(now_ns);
            }
        }
        let is_now = |at_ns: i64| now_ns.saturating_sub(at_ns) <= NOW_NS;
        let come = self.seen_ns.iter().all(|(_, seen_ns)| seen_ns.is_some_and(is_now));
        if !come || self.seen_ns.iter().all(|(marker, _)| has(*marker)) {
            self.since_ns = None;
            return false;
        }
        now_ns.saturating_sub(*self.since_ns.get_or_insert(now_ns)) >= SAID_AFTER_NS
    }
}
