//! How long frames may have waited on the peer's side, where its clock seems to have been set back.
//!
//! Arrivals alone cannot tell a clock that was set back by 3 s from a queue that grew by 3 s. The stamps can, in part: a queue hands frames on
//! in their order, so that no stamp of it goes back. What the law rises by more than stamps went back before, at once or little by little, may be
//! a queue's, and is kept until the law falls.

/// Less than this is not stated: what a law moves by on a busy link, ns. It is summed up all the same.
const LEAST_NS: i64 = 3_000_000;
/// A clock that was set is found at most so long after the stamp that went back, ns: [`super::trial`] takes 4 s.
const REMEMBERED_NS: i64 = 6_000_000_000;
/// No source of poses is slower, ns.
const LONGEST_NS: i64 = 200_000_000;
/// The weight of one more interval, one of so many.
const WEIGHT: i64 = 8;

#[derive(Debug, Clone, Default)]
pub(super) struct Backlog {
    /// Stamp and arrival of the frame before.
    last: Option<(i64, i64)>,
    /// The usual interval of stamps.
    interval_ns: i64,
    /// By how much stamps went back, less by how much they jumped forward, since that was forgotten last.
    went_back_ns: i64,
    jumped_ns: i64,
    /// How high the law lies above its lowest, but for what stamps show.
    sum_ns: i64,
}

impl Backlog {
    /// A frame came, whether or not it is mapped.
    pub(super) fn see(&mut self, device_ns: i64, arrival_ns: i64) {
        let Some((device_before, arrival_before)) = self.last.replace((device_ns, arrival_ns)) else {
            return;
        };
        if arrival_ns.saturating_sub(self.jumped_ns) > REMEMBERED_NS {
            self.went_back_ns = 0;
        }
        let by_stamps = device_ns.saturating_sub(device_before);
        let by_arrivals = arrival_ns.saturating_sub(arrival_before).max(0);
        let usual_ns = self.interval_ns;
        let ahead_ns = by_stamps.saturating_sub(by_arrivals);
        let back_ns = if by_stamps < 0 {
            usual_ns.saturating_sub(by_stamps)
        } else if usual_ns > 0 && ahead_ns > 2 * usual_ns {
            // A stamp that is ahead of its clock is followed by one that goes back: that is no clock that was set.
            ahead_ns.saturating_neg()
        } else {
            // A pause is no interval.
            self.interval_ns = match usual_ns {
                0 => by_stamps.min(LONGEST_NS),
                _ => usual_ns + (by_stamps.min(2 * usual_ns) - usual_ns) / WEIGHT,
            };
            return;
        };
        self.went_back_ns = self.went_back_ns.saturating_add(back_ns);
        self.jumped_ns = arrival_ns;
    }

    /// The law rose by so much: its clock was set back, or all frames wait longer. It fell where that is negative.
    pub(super) fn rises(&mut self, by_ns: i64) {
        if by_ns <= 0 {
            // It was seen as a jump of the stamps too: that takes nothing from what they go back by later.
            let jumped_ns = self.went_back_ns.saturating_sub(by_ns).min(0);
            self.went_back_ns = self.went_back_ns.max(jumped_ns);
            self.sum_ns = self.sum_ns.saturating_add(by_ns).max(0);
            return;
        }
        let rest_ns = self.hidden(by_ns);
        self.went_back_ns = self.went_back_ns.saturating_sub(self.went_back_ns.clamp(0, by_ns));
        self.sum_ns = self.sum_ns.saturating_add(rest_ns);
    }

    /// How much of so much lateness no stamp shows that went back. What lay between two frames whose stamps go back is known to one interval, and
    /// hardly better the law that begins with the second.
    pub(super) fn hidden(&self, late_ns: i64) -> i64 {
        let shown_ns = self.went_back_ns.clamp(0, late_ns.max(0));
        let rest_ns = late_ns.saturating_sub(shown_ns).max(0);
        let slack_ns = if shown_ns > 0 { self.interval_ns } else { 0 };
        if rest_ns > slack_ns { rest_ns } else { 0 }
    }

    /// How long frames may have waited beside what the law says, ns.
    pub(super) fn ns(&self) -> i64 {
        if self.sum_ns < LEAST_NS { 0 } else { self.sum_ns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    /// 50 Hz for a second.
    fn steady() -> Backlog {
        let mut backlog = Backlog::default();
        (0..50).for_each(|k| backlog.see(k * 20 * MS, k * 20 * MS));
        backlog
    }

    #[test]
    fn steps_that_no_stamp_shows_add_up_until_the_clock_steps_forward() {
        let mut backlog = steady();
        for by_ms in [2, 72, 225, 229] {
            backlog.rises(by_ms * MS);
        }
        assert_eq!(backlog.ns(), 528 * MS);
        backlog.rises(-500 * MS);
        assert_eq!(backlog.ns(), 28 * MS);
        backlog.rises(i64::MIN);
        assert_eq!(backlog.ns(), 0);
        backlog.rises(i64::MAX);
        backlog.rises(i64::MAX);
        assert_eq!(backlog.ns(), i64::MAX);
    }

    #[test]
    fn a_step_that_a_stamp_shows_is_a_clock_that_was_set_but_not_one_behind_a_stamp_that_was_ahead_or_long_ago() {
        let mut set = steady();
        set.see(1000 * MS - 3000 * MS, 1000 * MS);
        let mut more = set.clone();
        let mut late = set.clone();
        set.rises(3010 * MS);
        assert_eq!(set.ns(), 0);
        // What stamps went back by counts once.
        set.rises(500 * MS);
        assert_eq!(set.ns(), 500 * MS);
        more.rises(3200 * MS);
        assert_eq!(more.ns(), 200 * MS);
        late.see(4100 * MS, 7100 * MS);
        late.rises(3000 * MS);
        assert_eq!(late.ns(), 3000 * MS);
        let mut stray = steady();
        stray.see(1000 * MS + 3000 * MS, 1000 * MS);
        stray.see(1020 * MS, 1020 * MS);
        stray.rises(3000 * MS);
        assert!(stray.ns() > 2900 * MS, "{}", stray.ns());
    }
}
