//! How long frames may have waited on the peer's side, where its clock seems to have been set back.
//!
//! Nothing tells a clock that was set back by 3 s from a queue that grew by 3 s. Not even stamps that go back do: a peer that hands on once
//! more what it kept, in order and at its pace, and stays behind from then on, gives the same stamps as a clock that was set. So whatever the law
//! rises by, at once or little by little, may be a queue's, and is kept until the law falls by as much.

/// Less than this is not stated: what a law moves by on a busy link, ns. It is summed up all the same.
const LEAST_NS: i64 = 3_000_000;
/// A law that falls by so much more than frames may have waited was not a queue's alone, ns: what laws fall by on a busy link is less.
const MORE_NS: i64 = 50_000_000;

#[derive(Debug, Clone, Default)]
pub(super) struct Backlog {
    /// How high the law lies above its lowest.
    sum_ns: i64,
}

impl Backlog {
    /// Frames may have waited for so long from the beginning on.
    pub(super) fn of(waited_ns: i64) -> Self {
        Self {
            sum_ns: waited_ns.max(0),
        }
    }

    /// The law rose by so much: its clock was set back, or all frames wait longer. It fell where that is negative.
    pub(super) fn rises(&mut self, by_ns: i64) {
        let rest_ns = self.sum_ns.saturating_add(by_ns);
        // No queue ends by more than it was: the clock was set forward, and how much of that the queue was, nothing tells.
        if rest_ns >= -MORE_NS || self.sum_ns < LEAST_NS {
            self.sum_ns = rest_ns.max(0);
        }
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

    #[test]
    fn steps_add_up_until_the_clock_steps_forward_by_as_much() {
        let mut backlog = Backlog::default();
        for by_ms in [2, 72, 225, 229] {
            backlog.rises(by_ms * MS);
        }
        assert_eq!(backlog.ns(), 528 * MS);
        backlog.rises(-500 * MS);
        assert_eq!(backlog.ns(), 28 * MS);
        backlog.rises(-30 * MS);
        assert_eq!(backlog.ns(), 0);
        backlog.rises(i64::MIN);
        assert_eq!(backlog.ns(), 0);
        backlog.rises(i64::MAX);
        backlog.rises(i64::MAX);
        assert_eq!(backlog.ns(), i64::MAX);
    }

    /// A queue of 2 s was forgotten when the peer's clock was set forward by 3 s, or back and right again.
    #[test]
    fn a_clock_that_is_set_ends_no_queue_by_more_than_it_was() {
        for steps in [[3000, -3000], [-3000, 3000]] {
            let mut backlog = Backlog::of(2000 * MS);
            for by_ms in steps {
                backlog.rises(by_ms * MS);
                assert!(backlog.ns() >= 2000 * MS, "{steps:?}: {}", backlog.ns());
            }
        }
    }
}
