//! The run's times as they stand on the wire.

use bus::clock;
use igtl::Stamp;
use rustix::time::{ClockId, clock_gettime};

/// A look at the clocks that took longer was interrupted, ns.
const UNDISTURBED_NS: i64 = 20_000;

/// What turns the run's times into those of the wire.
#[derive(Debug, Clone, Copy)]
pub(super) struct Times {
    /// CLOCK_MONOTONIC at the run's start, ns.
    pub(super) epoch_ns: i64,
    pub(super) stale_ns: i64,
    pub(super) is_present: bool,
}

impl Times {
    /// When something was captured, by this machine's wall clock; no time where it is not of the present.
    pub(super) fn stamp(self, t_capture_ns: i64) -> Stamp {
        if !self.is_present {
            return Stamp::NONE;
        }
        let at_ns = wall_ahead_ns().saturating_add(self.epoch_ns.saturating_add(t_capture_ns));
        u64::try_from(at_ns).ok().and_then(Stamp::of_ns).unwrap_or(Stamp::NONE)
    }

    /// Until when something is young, ns on CLOCK_MONOTONIC; for ever where time is not the present's.
    pub(super) fn until_ns(self, t_capture_ns: i64) -> Option<i64> {
        let captured_ns = self.epoch_ns.saturating_add(t_capture_ns);
        self.is_present.then(|| captured_ns.saturating_add(self.stale_ns))
    }
}

/// How far the wall clock is ahead of CLOCK_MONOTONIC, ns.
fn wall_ahead_ns() -> i64 {
    closest(std::iter::repeat_with(|| {
        let before_ns = clock::monotonic_ns();
        let wall = clock_gettime(ClockId::Realtime);
        let wall_ns = wall.tv_sec * 1_000_000_000 + wall.tv_nsec;
        (before_ns, wall_ns, clock::monotonic_ns())
    }))
}

/// How far the wall clock is ahead by looks at one clock, the wall's, and the first again. A thread that loses the processor between two of
/// them takes one clock for later than it is: the first look that was not interrupted counts, or of a few the closest.
fn closest(looks: impl Iterator<Item = (i64, i64, i64)>) -> i64 {
    let mut best: Option<(i64, i64)> = None;
    for (before_ns, wall_ns, after_ns) in looks.take(4) {
        let took_ns = after_ns.saturating_sub(before_ns);
        if best.is_none_or(|(least, _)| took_ns < least) {
            best = Some((took_ns, wall_ns.saturating_sub(before_ns + took_ns / 2)));
        }
        if took_ns < UNDISTURBED_NS {
            break;
        }
    }
    best.map_or(0, |(_, ahead_ns)| ahead_ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_at_the_clocks_that_was_interrupted_moves_no_stamp() {
        let ms = 1_000_000;
        let looks = [
            (0, 905 * ms, 10 * ms),
            (20 * ms, 920 * ms + 500, 20 * ms + 1000),
            (0, 0, 0),
        ];
        assert_eq!(closest(looks.into_iter()), 900 * ms);
        // Where all were, the closest.
        let looks = [
            (0, 907 * ms, 10 * ms),
            (20 * ms, 921 * ms, 22 * ms),
            (30 * ms, 939 * ms, 40 * ms),
        ];
        assert_eq!(closest(looks.into_iter()), 900 * ms);
    }

    #[test]
    fn what_is_not_of_the_present_has_no_stamp_and_no_end() {
        let times = |is_present| Times {
            epoch_ns: 100,
            stale_ns: 10,
            is_present,
        };
        assert_eq!((times(false).stamp(5), times(false).until_ns(5)), (Stamp::NONE, None));
        assert_eq!(times(true).until_ns(5), Some(115));
        assert_ne!(times(true).stamp(5), Stamp::NONE);
    }
}
