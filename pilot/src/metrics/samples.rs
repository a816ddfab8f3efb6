//! From the capture of a sample to its publication, of every sample, whether an image showed it or not.

use bus::clock::ms;
use bus::message::ToolPose;
use fit::Histogram;

use super::{Latency, percentiles};

/// Its key in the report, beside those of the stages.
pub(crate) const ALL: &str = "capture_to_publish_all";

/// Durations, ms, from a microsecond to a quarter of an hour.
#[derive(Debug)]
pub(crate) struct Samples(Histogram);

impl Default for Samples {
    fn default() -> Self {
        Self(Histogram::new(1e-3, 1e6))
    }
}

impl Samples {
    /// A sample that was not refused.
    pub(crate) fn add(&mut self, pose: &ToolPose) {
        self.0.add(ms(pose.t_publish_ns.saturating_sub(pose.t_capture_ns)));
    }

    /// Its percentiles.
    pub(crate) fn latency(&self) -> Latency {
        percentiles(&self.0)
    }
}
