//! One monotonic clock per run: nanoseconds since the run's epoch.
//!
//! Every process of a run reads CLOCK_MONOTONIC, which is one clock for the whole machine, and subtracts the epoch that
//! the pilot took when the run began. Stamps of different processes can so be compared.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

/// Nanoseconds of CLOCK_MONOTONIC, without any epoch.
pub fn monotonic_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// A source of stamps: the machine's clock, or one that a test moves by hand.
#[derive(Debug, Clone)]
pub struct Clock(Inner);

#[derive(Debug, Clone)]
enum Inner {
    Monotonic { epoch_ns: i64 },
    Fake(Rc<Cell<i64>>),
}

impl Clock {
    /// The run's clock.
    pub fn monotonic(epoch_ns: i64) -> Self {
        Self(Inner::Monotonic { epoch_ns })
    }

    /// A clock that stands at `now_ns` until [`Clock::advance`] is called; its clones move with it.
    pub fn fake(now_ns: i64) -> Self {
        Self(Inner::Fake(Rc::new(Cell::new(now_ns))))
    }

    /// Nanoseconds since the run's epoch.
    pub fn now_ns(&self) -> i64 {
        match &self.0 {
            Inner::Monotonic { epoch_ns } => monotonic_ns() - epoch_ns,
            Inner::Fake(now) => now.get(),
        }
    }

    /// Moves a fake clock on. The machine's clock cannot be moved: it ignores this.
    pub fn advance(&self, by: Duration) {
        if let Inner::Fake(now) = &self.0 {
            now.set(now.get().saturating_add(ns(by)));
        }
    }

    /// Sleeps until the clock shows `deadline_ns`, or not at all where that is past. A fake clock jumps there.
    pub fn sleep_until(&self, deadline_ns: i64) {
        let left = deadline_ns.saturating_sub(self.now_ns());
        let Ok(left) = u64::try_from(left) else { return };
        match &self.0 {
            Inner::Monotonic { .. } => std::thread::sleep(Duration::from_nanos(left)),
            Inner::Fake(now) => now.set(deadline_ns),
        }
    }
}

/// A duration in nanoseconds, saturating at 292 years.
pub fn ns(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}

/// Seconds as nanoseconds; saturates, and NaN gives 0.
pub fn seconds(s: f64) -> i64 {
    (s * 1e9).round() as i64
}

/// Nanoseconds as milliseconds, for people and reports.
pub fn ms(ns: i64) -> f64 {
    ns as f64 / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fake_clocks_move_together_and_only_by_hand() {
        let clock = Clock::fake(5);
        let other = clock.clone();
        clock.advance(Duration::from_millis(1));
        assert_eq!(other.now_ns(), 1_000_005);
        other.sleep_until(2_000_000);
        assert_eq!(clock.now_ns(), 2_000_000);
        clock.sleep_until(0);
        assert_eq!(clock.now_ns(), 2_000_000);
    }

    #[test]
    fn the_monotonic_clock_counts_from_the_epoch() {
        let clock = Clock::monotonic(monotonic_ns());
        let first = clock.now_ns();
        assert!(first >= 0);
        assert!(clock.now_ns() >= first);
    }
}
