//! How long a frame waits for its last marker.
//!
//! Half the time between two messages of one marker; longer where the last marker is known to come later, up to what it took. That only
//! where stamps have told instants apart for a while: each marker came under each of them, and once.

/// Frames come at least so far apart, and at most: what half of is waited for, ns.
const LEAST_NS: i64 = 2_000_000;
const MOST_NS: i64 = 100_000_000;
/// Before anything is known: 50 Hz.
const FIRST_NS: i64 = 20_000_000;
/// The weight of one more time between two frames.
const WEIGHT: f64 = 0.1;

/// So many stamps in a row must have had every marker once before a frame waits longer. Under a clock that goes on each 15.6 ms, a tool and
/// a patient of two instants share fewer in a row, unless both come at nearly its pace.
const STAMPS: u32 = 32;
/// Nobody waits longer, ns.
const LONGEST_NS: f64 = 250e6;
/// What the last marker took is waited for with so much more.
const MORE: f64 = 1.25;
/// What is left of it with each frame of which that is not so.
const FORGETS: f64 = 0.98;

/// What has come.
#[derive(Debug, Clone)]
pub(super) struct Patience {
    /// When each marker came last, ns.
    came_ns: Vec<(u32, i64)>,
    period_ns: f64,
    /// How long the last marker of a frame took from the first, ns.
    late_ns: f64,
    /// So many stamps in a row had every marker once.
    whole: u32,
}

impl Patience {
    pub(super) fn new() -> Self {
        Self {
            came_ns: Vec::new(),
            period_ns: FIRST_NS as f64,
            late_ns: 0.0,
            whole: 0,
        }
    }

    /// The time between two frames is that between two messages of one marker, whatever their stamps are.
    pub(super) fn measure(&mut self, marker: u32, now_ns: i64) {
        match self.came_ns.iter_mut().find(|(other, _)| *other == marker) {
            None => self.came_ns.push((marker, now_ns)),
            Some((_, last_ns)) => {
                let before_ns = std::mem::replace(last_ns, now_ns);
                let period_ns = now_ns.saturating_sub(before_ns).clamp(LEAST_NS, MOST_NS);
                self.period_ns += WEIGHT * (period_ns as f64 - self.period_ns);
            }
        }
    }

    /// A stamp is over, which had every marker once or not.
    pub(super) fn stamp_ended(&mut self, is_whole: bool) {
        self.whole = if is_whole { self.whole.saturating_add(1) } else { 0 };
        self.late_ns *= FORGETS;
    }

    /// The last marker of a stamp came so long after its first.
    pub(super) fn last_came(&mut self, after_ns: i64) {
        self.late_ns = self.late_ns.max(after_ns as f64);
    }

    /// How long a frame waits, ns.
    pub(super) fn waits_ns(&self) -> i64 {
        let half_ns = self.period_ns / 2.0;
        let late_ns = (MORE * self.late_ns).min(LONGEST_NS);
        let waits_ns = if self.whole >= STAMPS {
            half_ns.max(late_ns)
        } else {
            half_ns
        };
        waits_ns as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_marker_is_waited_for_once_stamps_have_told_instants_apart_and_forgotten_again() {
        const MS: i64 = 1_000_000;
        let mut patience = Patience::new();
        assert_eq!(patience.waits_ns(), 10 * MS);
        for k in 0..STAMPS {
            assert_eq!(patience.waits_ns(), 10 * MS, "{k}");
            patience.last_came(16 * MS);
            patience.stamp_ended(true);
        }
        // One stamp later: 16 ms and a quarter, of which two in a hundred are forgotten.
        assert_eq!(patience.waits_ns(), 19_600_000);
        patience.last_came(10_000 * MS);
        assert_eq!(patience.waits_ns(), 250 * MS);
        patience.stamp_ended(false);
        assert_eq!(patience.waits_ns(), 10 * MS);
        // 0.98^300 of 10 s.
        (0..300).for_each(|_| patience.stamp_ended(true));
        assert!(
            (28 * MS..30 * MS).contains(&patience.waits_ns()),
            "{}",
            patience.waits_ns()
        );
    }
}
