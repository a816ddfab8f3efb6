//! What is stated of a link, and what became known of it.

use super::quality::Reason;
use super::spread::Spread;

/// How stamps are mapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The law rests on frames of so many nanoseconds; at least a second is taken.
    pub window_ns: i64,
    /// The greatest skew between the clocks, parts per million.
    pub skew_ppm: f64,
    /// What is known of the least delay from capture to arrival, nanoseconds: it is taken off every stamp. Negative is taken as 0.
    pub least_delay_ns: i64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            window_ns: 20_000_000_000,
            skew_ppm: 200.0,
            least_delay_ns: 0,
        }
    }
}

/// What is known of a device's clock, for status lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Status {
    /// How late mapped frames of the window came.
    pub spread: Spread,
    /// By how much the run's clock is faster than the device's, parts per million.
    pub skew_ppm: f64,
    /// Steps since the beginning.
    pub steps: u64,
    /// Frames that were mapped.
    pub mapped: u64,
    /// Frames that had the time of their arrival, by reason in the order of [`Reason::ALL`].
    pub arrivals: [u64; Reason::ALL.len()],
}
