//! When frames are captured and when they come.

use scene::operating_room::Timing;

use super::RoomError;
use chance::Chance;

/// The fastest localizer, frames a second.
const MOST_HZ: f64 = 1e5;
/// Draws of one frame for its way to us; its emitters draw below these.
pub(super) const JITTER_DRAW: u64 = 10_000;
const LATE_DRAW: u64 = 10_001;
const DROPPED_DRAW: u64 = 10_002;

/// A frame on its way. Ordered by arrival; frames that arrive together, by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrival {
    /// Script time, ns.
    pub t_arrival_ns: i64,
    /// The frame's number.
    pub seq: u64,
}

/// The localizer's clock and its line to us.
#[derive(Debug, Clone)]
pub(super) struct Delivery {
    timing: Timing,
    seed: u64,
    rate_hz: f64,
    end_ns: i64,
}

impl Delivery {
    /// Frames at `rate_hz` until script time `end_s`, if the script has an end.
    pub(super) fn new(timing: Timing, seed: u64, rate_hz: f64, end_s: Option<f64>) -> Result<Self, RoomError> {
        if !(rate_hz > 0.0 && rate_hz <= MOST_HZ) {
            return Err(RoomError::Rate { rate_hz, most: MOST_HZ });
        }
        Ok(Self {
            timing,
            seed,
            rate_hz,
            end_ns: end_s.map_or(i64::MAX, ns),
        })
    }

    /// Script time of the capture, ns.
    pub(super) fn capture_ns(&self, seq: u64) -> i64 {
        (seq as f64 * 1e9 / self.rate_hz).round() as i64
    }

    /// What the localizer's clock says then: `offset + t (1 + drift)`, ns.
    pub(super) fn device_ns(&self, capture_ns: i64) -> i64 {
        let gained = (capture_ns as f64 * self.timing.drift_ppm * 1e-6).round() as i64;
        ns(self.timing.offset_s)
            .saturating_add(capture_ns)
            .saturating_add(gained)
    }

    /// Script time of the arrival, ns, and whether the frame is dropped instead.
    pub(super) fn arrival(&self, seq: u64) -> (i64, bool) {
        let (chance, t) = (Chance::new(self.seed, seq), &self.timing);
        let mut delay_s = t.latency_s + t.jitter_s * chance.uniform(JITTER_DRAW);
        if chance.uniform(LATE_DRAW) < t.late {
            delay_s += t.late_s;
        }
        let capture_ns = self.capture_ns(seq);
        let dropped = chance.uniform(DROPPED_DRAW) < t.dropped || capture_ns > self.end_ns;
        (capture_ns.saturating_add(ns(delay_s)), dropped)
    }

    /// See [`super::OperatingRoom::arrivals`].
    pub(super) fn arrivals(&self, after_ns: i64, until_ns: i64, into: &mut Vec<Arrival>) {
        into.clear();
        let numbers = self.captured(after_ns)..=self.last_before(until_ns);
        into.extend(numbers.filter_map(|seq| self.within(seq, after_ns, until_ns)));
        into.sort_unstable();
    }

    /// See [`super::OperatingRoom::next_arrival`].
    pub(super) fn next_arrival(&self, after_ns: i64, until_ns: i64) -> Option<Arrival> {
        let mut first: Option<Arrival> = None;
        for seq in self.captured(after_ns)..=self.last_before(until_ns) {
            // None comes before it is captured.
            if first.is_some_and(|first| self.capture_ns(seq) > first.t_arrival_ns) {
                break;
            }
            first = first.into_iter().chain(self.within(seq, after_ns, until_ns)).min();
        }
        first
    }

    fn within(&self, seq: u64, after_ns: i64, until_ns: i64) -> Option<Arrival> {
        let (t_arrival_ns, dropped) = self.arrival(seq);
        let comes = !dropped && t_arrival_ns > after_ns && t_arrival_ns <= until_ns;
        comes.then_some(Arrival { t_arrival_ns, seq })
    }

    /// A frame such that all before it have arrived by `t_ns`, however late they were.
    fn captured(&self, t_ns: i64) -> u64 {
        self.last_before(t_ns.saturating_sub(self.longest_ns()))
            .saturating_sub(2)
    }

    /// See [`super::OperatingRoom::longest_delay_ns`].
    pub(super) fn longest_ns(&self) -> i64 {
        let t = &self.timing;
        ns(t.latency_s + t.jitter_s + t.late_s)
    }

    /// A frame that is captured at `t_ns` or later, or the last one; at most two too far.
    fn last_before(&self, t_ns: i64) -> u64 {
        // A negative number becomes 0: the first frame is captured at 0.
        (t_ns.min(self.end_ns) as f64 * self.rate_hz / 1e9).ceil() as u64 + 1
    }
}

fn ns(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}
