//! The clock of another machine, from questions and answers that go both ways.
//!
//! A question leaves at `sent` and its answer comes at `came`, both on this machine's clock; the other machine heard it at `heard` and
//! answered at `answered`, on its own. As nothing arrives before it is sent, the offset *other less this* lies
//!
//! ```text
//! answered - came <= offset <= heard - sent
//! ```
//!
//! whatever either way took. Two clocks of CLOCK_MONOTONIC drift against each other by at most [`DRIFT`], so that an older answer
//! still says something, between bounds that widen as time goes by; what is known is where all of them overlap. This is no estimate: where
//! the drift is bounded as stated, the truth is never outside. The price is that half of the shortest round trip stays unknown
//! (Cristian 1989, Marzullo 1984).

use super::Law;

/// How fast two clocks may drift against each other: each is slewed by at most 500 ppm (the limit of adjtimex), of a crystal of at most 100.
pub const DRIFT: f64 = 1.2e-3;

/// A question to the other machine, and its answer, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exchange {
    /// When it was asked, on this machine's CLOCK_MONOTONIC.
    pub sent_ns: i64,
    /// When the other machine heard it, on the clock that is asked for.
    pub heard_ns: i64,
    /// When the other machine answered, on the clock that is asked for.
    pub answered_ns: i64,
    /// When the answer came, on this machine's CLOCK_MONOTONIC.
    pub came_ns: i64,
}

/// Why an answer says nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "an answer about the clock took {round_trip_ns} ns, of which the other machine says it held it for {held_ns} ns; expected 0 <= held \
     <= round trip + its drift"
)]
pub struct ExchangeError {
    round_trip_ns: i64,
    held_ns: i64,
}

/// What is known of the other machine's clock.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FarClock {
    known: Option<Bounds>,
    /// How often an answer contradicted those before it.
    steps: u64,
}

/// Between which the offset *other less this* lies, at a moment of this machine's clock, ns.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    at_ns: i64,
    least_ns: i64,
    most_ns: i64,
}

impl Bounds {
    /// The same at a later moment.
    fn at(self, at_ns: i64) -> Self {
        let drift = drift_ns(at_ns.saturating_sub(self.at_ns));
        Self {
            at_ns,
            least_ns: self.least_ns.saturating_sub(drift),
            most_ns: self.most_ns.saturating_add(drift),
        }
    }
}

fn drift_ns(passed_ns: i64) -> i64 {
    (DRIFT * passed_ns.max(0) as f64).ceil() as i64
}

impl FarClock {
    /// Takes in an answer. Returns whether it contradicts the earlier ones: a clock was set, or a machine stood still. Only the
    /// newest counts then.
    ///
    /// # Errors
    /// [`ExchangeError`], and what was known stays.
    pub fn take(&mut self, exchange: Exchange) -> Result<bool, ExchangeError> {
        let round_trip_ns = exchange.came_ns.saturating_sub(exchange.sent_ns);
        let held_ns = exchange.answered_ns.saturating_sub(exchange.heard_ns);
        let drift = drift_ns(round_trip_ns);
        if round_trip_ns < 0 || held_ns < 0 || held_ns > round_trip_ns.saturating_add(drift) {
            return Err(ExchangeError { round_trip_ns, held_ns });
        }
        // Each bound holds at one end of the exchange; at its other end the clocks have drifted.
        let new = Bounds {
            at_ns: exchange.came_ns,
            least_ns: exchange.answered_ns.saturating_sub(exchange.came_ns),
            most_ns: exchange.heard_ns.saturating_sub(exchange.sent_ns).saturating_add(drift),
        };
        let old = self.known.map(|known| known.at(exchange.came_ns));
        let both = old.map(|old| Bounds {
            least_ns: new.least_ns.max(old.least_ns),
            most_ns: new.most_ns.min(old.most_ns),
            ..new
        });
        let contradicts = both.is_some_and(|both| both.least_ns > both.most_ns);
        self.known = Some(both.filter(|_| !contradicts).unwrap_or(new));
        self.steps += u64::from(contradicts);
        Ok(contradicts)
    }

    /// This machine stood still for so long, ns, while its CLOCK_MONOTONIC did not go on: the other's may be ahead by as much.
    pub fn stood_still(&mut self, for_ns: i64) {
        if let Some(known) = &mut self.known {
            known.most_ns = known.most_ns.saturating_add(for_ns.max(0));
        }
    }

    /// Forgets everything: the other clock is another one now.
    pub fn forget(&mut self) {
        self.known = None;
    }

    /// A clock that is never behind the other machine's, from the newest answer on: who goes by it takes nothing for younger than it is.
    /// `None` before the first answer.
    pub fn latest(&self) -> Option<Law> {
        let known = self.known?;
        let shows_ns = known.at_ns.saturating_add(known.most_ns);
        // In range by its constant.
        Law::new(shows_ns, known.at_ns, 1.0 + DRIFT).ok()
    }

    /// How far the clock is known at `now_ns` of CLOCK_MONOTONIC: the truth is at most as far from the middle of the bounds, and
    /// [`FarClock::latest`] at most twice as far ahead of it. ns; `None` before the first answer.
    pub fn uncertain_ns(&self, now_ns: i64) -> Option<i64> {
        let now = self.known?.at(now_ns);
        Some(now.most_ns.saturating_sub(now.least_ns).saturating_add(1) / 2)
    }

    /// The middle of the bounds at `now_ns`: what the other clock most likely shows then, ns.
    pub fn likely_ns(&self, now_ns: i64) -> Option<i64> {
        let now = self.known?.at(now_ns);
        let middle = (i128::from(now.least_ns) + i128::from(now.most_ns)) / 2;
        Some(now_ns.saturating_add(middle as i64))
    }

    /// How often an answer contradicted those before it.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Ten pings a second to a clock of this offset and drift (ppm), each way as long as it likes.
    fn walked(offset_ns: i64, ppm: f64, ways_us: &[(u32, u32)]) -> Result<(), TestCaseError> {
        let other = |t: i64| offset_ns + t + (ppm * 1e-6 * t as f64) as i64;
        let mut far = FarClock::default();
        let mut t = 0;
        for &(there, back) in ways_us {
            let heard = t + i64::from(there) * 1000;
            let came = heard + 20_000 + i64::from(back) * 1000;
            let exchange = Exchange {
                sent_ns: t,
                heard_ns: other(heard),
                answered_ns: other(heard + 20_000),
                came_ns: came,
            };
            prop_assert!(!far.take(exchange).unwrap());
            for later in [came, came + 50_000_000, came + 10_000_000_000] {
                // A nanosecond for each number of the test that was rounded.
                let ahead = far.latest().unwrap().at(later) - other(later);
                let uncertain = far.uncertain_ns(later).unwrap();
                prop_assert!(ahead >= -2, "{ahead} ns");
                prop_assert!(ahead <= 2 * uncertain + 4);
                prop_assert!((far.likely_ns(later).unwrap() - other(later)).abs() <= uncertain + 2);
            }
            t = came + 100_000_000;
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn the_truth_is_never_outside_and_no_age_is_too_young(
            offset in -1_i64 << 55..1_i64 << 55, ppm in -1199.0..1199.0,
            ways in prop::collection::vec((1_u32..200_000, 1_u32..200_000), 1..40))
        {
            walked(offset, ppm, &ways)?;
        }
    }

    #[test]
    fn the_shortest_round_trip_decides_and_asymmetry_costs_half_of_it() {
        let mut far = FarClock::default();
        for round in [3_000_000, 400_000, 9_000_000] {
            let exchange = Exchange {
                sent_ns: 0,
                heard_ns: 5_000_000_000,
                answered_ns: 5_000_000_000,
                came_ns: round,
            };
            far.take(exchange).unwrap();
        }
        // 400 us of round trip, and the drift of 9 ms.
        let uncertain = far.uncertain_ns(9_000_000).unwrap();
        assert!((200_000..212_000).contains(&uncertain), "{uncertain}");
    }

    #[test]
    fn a_clock_that_was_set_is_told_and_known_anew() {
        let mut far = FarClock::default();
        let at = |t: i64, offset: i64| Exchange {
            sent_ns: t,
            heard_ns: t + offset,
            answered_ns: t + offset,
            came_ns: t + 100_000,
        };
        assert!(!far.take(at(0, 7_200_000_000_000)).unwrap());
        assert!(far.take(at(1_000_000_000, 7_200_080_000_000)).unwrap());
        assert_eq!(far.steps(), 1);
        let ahead = far.latest().unwrap().at(1_000_100_000) - (1_000_100_000 + 7_200_080_000_000);
        assert!((0..=100_200).contains(&ahead), "{ahead}");
    }

    #[test]
    fn time_that_this_machine_slept_makes_nothing_younger() {
        let mut far = FarClock::default();
        far.take(Exchange {
            sent_ns: 0,
            heard_ns: 50,
            answered_ns: 50,
            came_ns: 100,
        })
        .unwrap();
        far.stood_still(3_600_000_000_000);
        assert!(far.latest().unwrap().at(100) >= 3_600_000_000_050);
    }

    #[test]
    fn answers_that_cannot_be_are_refused_and_change_nothing() {
        let mut far = FarClock::default();
        let good = Exchange {
            sent_ns: 0,
            heard_ns: 10,
            answered_ns: 20,
            came_ns: 30,
        };
        far.take(good).unwrap();
        let before = far;
        for bad in [
            Exchange { came_ns: -1, ..good },
            Exchange { heard_ns: 21, ..good },
            Exchange {
                answered_ns: 1000,
                ..good
            },
            Exchange {
                heard_ns: i64::MIN,
                answered_ns: i64::MAX,
                ..good
            },
        ] {
            let error = far.take(bad).unwrap_err().to_string();
            assert!(error.contains("expected 0 <= held"), "{error}");
            assert_eq!(far, before);
        }
    }
}
