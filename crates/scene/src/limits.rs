//! `[limits]`: when to warn, restart and give up.

use std::time::Duration;

use super::raw::RawLimits;
use super::values::{Checked, invalid, number, seconds};

/// When to warn, restart and give up.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// An image whose pose is older than this says so.
    pub stale: Duration,
    /// A pose that is older than this is none. At least [`Limits::stale`].
    pub lost: Duration,
    /// The same measurement under fresh stamps for longer than this is none.
    pub frozen: Duration,
    /// A process without a sign of life for this long is restarted.
    pub silent: Duration,
    /// A process that is not ready after this long is restarted.
    pub start: Duration,
    /// Restarts of one process within [`Limits::restart_window`] before it is held.
    pub restarts: u32,
    /// See [`Limits::restarts`].
    pub restart_window: Duration,
    /// How long processes may take to end when asked.
    pub stop: Duration,
    /// More of a run's samples missing than this share is a problem.
    pub max_missing_share: f64,
    /// Images later than this behind the capture of their pose, at the 99th percentile, are a problem; `None`: they are not.
    pub latency_p99: Option<Duration>,
}

/// After so long without a pose there is none, or after twice the time that makes it stale, unless the scene says otherwise.
const LOST_MS: f64 = 1000.0;

/// Checks `[limits]`.
pub(super) fn limits(raw: &RawLimits) -> Checked<Limits> {
    let stale_ms = number("limits.stale_ms", raw.stale_ms, 1.0..=10_000.0, "ms")?;
    let lost_ms = match raw.lost_ms {
        Some(lost_ms) => number(
            "limits.lost_ms",
            lost_ms,
            stale_ms..=60_000.0,
            "ms, at least limits.stale_ms",
        )?,
        None => LOST_MS.max(2.0 * stale_ms),
    };
    let frozen_ms = number("limits.frozen_ms", raw.frozen_ms, 50.0..=60_000.0, "ms")?;
    if !(1..=100).contains(&raw.restarts) {
        return Err(invalid("limits.restarts", raw.restarts, "1 to 100"));
    }
    let latency_ms = raw.latency_p99_ms.unwrap_or(stale_ms);
    let latency_ms = number("limits.latency_p99_ms", latency_ms, 0.0..=60_000.0, "ms")?;
    Ok(Limits {
        stale: Duration::from_secs_f64(stale_ms / 1e3),
        lost: Duration::from_secs_f64(lost_ms / 1e3),
        frozen: Duration::from_secs_f64(frozen_ms / 1e3),
        silent: seconds("limits.silent_s", raw.silent_s, 0.5..=60.0)?,
        start: seconds("limits.start_s", raw.start_s, 1.0..=3600.0)?,
        restarts: raw.restarts,
        restart_window: seconds("limits.restart_window_s", raw.restart_window_s, 1.0..=3600.0)?,
        stop: seconds("limits.stop_s", raw.stop_s, 0.1..=60.0)?,
        max_missing_share: number("limits.max_missing_share", raw.max_missing_share, 0.0..=1.0, "of 1")?,
        latency_p99: (latency_ms > 0.0).then(|| Duration::from_secs_f64(latency_ms / 1e3)),
    })
}
