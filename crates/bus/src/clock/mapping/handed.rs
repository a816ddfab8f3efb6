//! What is known of a device's clock, from a process that followed it to the one that comes after it.

use super::creep::Before;

/// A skew that is more is none of a clock: parts of one.
const MOST_SKEW: f64 = 1e-3;

/// What [`Mapping::hand_over`](super::Mapping::hand_over) gives, and [`Mapping::going_on`](super::Mapping::going_on) takes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Handed {
    /// The law; `None` where there was none.
    pub law: Option<HandedLaw>,
    /// How long frames may have waited beside what it says, ns.
    pub waited_ns: i64,
}

/// A law's line, which a queue that has come since is held against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandedLaw {
    /// A stamp, ns of the device's clock.
    pub device_ns: i64,
    /// When its frame arrives by the law at the earliest, ns on the run's clock.
    pub arrival_ns: i64,
    /// By how much the run's clock goes faster, parts of one.
    pub skew: f64,
}

impl HandedLaw {
    /// Its line at the stamp of the first frame that another law begins with, which arrives at `arrival_ns`: what is less than `least_ns` of
    /// the silence between both, ns, is no step.
    pub(super) fn before(&self, device_ns: i64, least_ns: impl Fn(f64) -> i64, arrival_ns: i64) -> Before {
        let skew = if self.skew.abs() <= MOST_SKEW { self.skew } else { 0.0 };
        let since_ns = device_ns.saturating_sub(self.device_ns);
        let by_line_ns = self.arrival_ns.saturating_add(since_ns);
        Before {
            device_ns,
            arrival_ns: by_line_ns.saturating_add((since_ns as f64 * skew) as i64),
            least_ns: least_ns(arrival_ns.saturating_sub(self.arrival_ns).max(0) as f64),
            counted_ns: 0,
        }
    }
}
