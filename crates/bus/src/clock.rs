//! One monotonic clock per run: nanoseconds since the run's epoch.
//!
//! Every process of a run reads CLOCK_MONOTONIC, which is one clock for the whole machine, and subtracts the epoch that
//! the pilot took when the run began. Stamps of different processes can so be compared.
//!
//! A replay has a second clock beside it, the recorded run's, which follows a [`Law`], and so has what is shown of another machine's run:
//! see [`crate::session`].

pub mod date;
pub mod far;
mod law;
pub mod mapping;

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

pub use law::{Law, LawError};

/// Nanoseconds of CLOCK_MONOTONIC, without any epoch.
pub fn monotonic_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// For how long this machine has slept since it was started, ns: CLOCK_MONOTONIC does not go on meanwhile, and other machines' clocks do.
pub fn slept_ns() -> i64 {
    let boot = clock_gettime(ClockId::Boottime);
    let boot_ns = boot.tv_sec * 1_000_000_000 + boot.tv_nsec;
    boot_ns - monotonic_ns()
}

/// A source of stamps: the machine's clock, that of a replay, or one that a test moves by hand.
#[derive(Debug, Clone)]
pub struct Clock(Inner);

#[derive(Debug, Clone)]
enum Inner {
    Monotonic { epoch_ns: i64 },
    Ruled(Rc<Cell<Law>>),
    Fake(Rc<Cell<i64>>),
}

impl Clock {
    /// The run's clock.
    pub fn monotonic(epoch_ns: i64) -> Self {
        Self(Inner::Monotonic { epoch_ns })
    }

    /// The clock of a replay; [`Clock::rule`] changes its law, for all of its clones at once.
    pub fn ruled(law: Law) -> Self {
        Self(Inner::Ruled(Rc::new(Cell::new(law))))
    }

    /// Gives the clock of a replay another law. The other kinds ignore this.
    pub fn rule(&self, law: Law) {
        if let Inner::Ruled(old) = &self.0 {
            old.set(law);
        }
    }

    /// A clock that stands at `now_ns` until [`Clock::advance`] is called; its clones move with it.
    pub fn fake(now_ns: i64) -> Self {
        Self(Inner::Fake(Rc::new(Cell::new(now_ns))))
    }

    /// Nanoseconds since the run's epoch.
    pub fn now_ns(&self) -> i64 {
        match &self.0 {
            Inner::Monotonic { epoch_ns } => monotonic_ns() - epoch_ns,
            Inner::Ruled(law) => law.get().at(monotonic_ns()),
            Inner::Fake(now) => now.get(),
        }
    }

    /// Moves a fake clock on. The machine's clock cannot be moved: it ignores this.
    pub fn advance(&self, by: Duration) {
        if let Inner::Fake(now) = &self.0 {
            now.set(now.get().saturating_add(ns(by)));
        }
    }

    /// Sleeps until the clock shows `deadline_ns`, or not at all where that is past, or where the clock of a replay stands
    /// still and never will. A fake clock jumps there.
    pub fn sleep_until(&self, deadline_ns: i64) {
        let left = match &self.0 {
            Inner::Ruled(law) => law
                .get()
                .when(deadline_ns)
                .map_or(0, |when| when.saturating_sub(monotonic_ns())),
            _ => deadline_ns.saturating_sub(self.now_ns()),
        };
        let Ok(left) = u64::try_from(left) else { return };
        match &self.0 {
            Inner::Monotonic { .. } | Inner::Ruled(_) => std::thread::sleep(Duration::from_nanos(left)),
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
    fn a_ruled_clock_and_its_clones_follow_one_law() {
        let clock = Clock::ruled(Law::still(5));
        let other = clock.clone();
        assert_eq!((clock.now_ns(), other.now_ns()), (5, 5));
        // Never reached: no sleep.
        clock.sleep_until(i64::MAX);
        clock.rule(Law::new(1_000, monotonic_ns(), 1.0).unwrap());
        assert!(other.now_ns() >= 1_000);
        let later = other.now_ns() + 2_000_000;
        other.sleep_until(later);
        assert!(clock.now_ns() >= later);
    }

    #[test]
    fn the_monotonic_clock_counts_from_the_epoch() {
        let clock = Clock::monotonic(monotonic_ns());
        let first = clock.now_ns();
        assert!(first >= 0);
        assert!(clock.now_ns() >= first);
    }
}
