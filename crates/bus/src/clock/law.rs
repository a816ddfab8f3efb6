//! How the clock of a replay follows the machine's.

/// The clock of a replay: `now_ns = anchor_ns + rate * (monotonic_ns - anchor_monotonic_ns)`, on the clock of the run that
/// was recorded. A rate of 1 is the speed of the recording, 0 a pause.
///
/// At rate 1 the difference is exact for 104 days (2^53 ns); at other rates it is rounded to a nanosecond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    anchor_ns: i64,
    anchor_monotonic_ns: i64,
    rate: f64,
}

/// Why numbers are no law of a clock.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a clock cannot run at {0} times the speed of the machine's; allowed are 0 to 1000")]
pub struct LawError(pub f64);

impl Law {
    /// The highest rate.
    pub const FASTEST: f64 = 1000.0;

    /// A clock that shows `anchor_ns` when CLOCK_MONOTONIC shows `anchor_monotonic_ns`, and runs at `rate`.
    ///
    /// # Errors
    /// [`LawError`] for a rate that is negative, not a number, or above [`Law::FASTEST`].
    pub fn new(anchor_ns: i64, anchor_monotonic_ns: i64, rate: f64) -> Result<Self, LawError> {
        if !(0.0..=Self::FASTEST).contains(&rate) {
            return Err(LawError(rate));
        }
        Ok(Self {
            anchor_ns,
            anchor_monotonic_ns,
            rate,
        })
    }

    /// A clock that stands at `now_ns`.
    pub const fn still(now_ns: i64) -> Self {
        Self {
            anchor_ns: now_ns,
            anchor_monotonic_ns: 0,
            rate: 0.0,
        }
    }

    /// What the clock shows when CLOCK_MONOTONIC shows `monotonic_ns`; saturates.
    pub fn at(&self, monotonic_ns: i64) -> i64 {
        let since = monotonic_ns.saturating_sub(self.anchor_monotonic_ns);
        // The cast saturates too.
        let gone = if self.rate == 1.0 {
            since
        } else {
            (self.rate * since as f64).round() as i64
        };
        self.anchor_ns.saturating_add(gone)
    }

    /// When CLOCK_MONOTONIC shows what it does as this clock shows `now_ns`; `None` where the clock stands still.
    pub fn when(&self, now_ns: i64) -> Option<i64> {
        if self.rate == 0.0 {
            return None;
        }
        let ahead = now_ns.saturating_sub(self.anchor_ns);
        let wait = if self.rate == 1.0 {
            ahead
        } else {
            (ahead as f64 / self.rate).round() as i64
        };
        Some(self.anchor_monotonic_ns.saturating_add(wait))
    }

    /// What the clock shows at the anchor, and CLOCK_MONOTONIC there.
    pub fn anchor(&self) -> (i64, i64) {
        (self.anchor_ns, self.anchor_monotonic_ns)
    }

    /// How fast the clock runs.
    pub fn rate(&self) -> f64 {
        self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn at_and_when_are_inverse(anchor in -1_i64 << 50..1_i64 << 50, machine in 0_i64..1 << 50,
                                   ahead in 0_i64..1 << 40, rate in prop::sample::select(vec![0.01, 0.25, 1.0, 3.0, 1000.0])) {
            let law = Law::new(anchor, machine, rate).unwrap();
            let when = law.when(anchor + ahead).unwrap();
            // Half a nanosecond of rounding on the machine's side is half a rate here; and one more rounding.
            let bound = (0.5 * rate).ceil() as i64 + 1;
            prop_assert!((law.at(when) - (anchor + ahead)).abs() <= bound);
        }

        #[test]
        fn at_the_recordings_speed_nothing_is_rounded(anchor in 0_i64..1 << 55, since in 0_i64..1 << 55) {
            prop_assert_eq!(Law::new(anchor, 7, 1.0).unwrap().at(7 + since), anchor + since);
        }
    }

    #[test]
    fn a_pause_stands_still_and_has_no_when() {
        let law = Law::still(42);
        assert_eq!((law.at(0), law.at(i64::MAX), law.when(42)), (42, 42, None));
    }

    #[test]
    fn extremes_saturate_and_impossible_rates_are_refused() {
        let law = Law::new(i64::MAX - 1, 0, 1000.0).unwrap();
        assert_eq!(law.at(i64::MAX), i64::MAX);
        for rate in [-1e-9, 1000.1, f64::NAN, f64::INFINITY] {
            let text = Law::new(0, 0, rate).unwrap_err().to_string();
            assert!(text.contains("allowed are 0 to 1000"), "{text}");
        }
    }
}
