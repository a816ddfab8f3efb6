//! When a run is over: of itself, or because nothing goes on any more.

use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{Counters, Heartbeat, ProcessState, ToolPose};
use scene::TrackerSource;

use crate::state::Run;

/// How long the end of a timed run waits for its last pose, on a machine that is held up: whoever simulates goes on beyond it.
const GRACE: Duration = Duration::from_secs(10);
/// How long the last poses of another program may be under way.
const ON_ITS_WAY: Duration = Duration::from_millis(100);
/// What a tracker in simulated time may wait for somebody who takes no poses, ns, with room to spare.
const STANDSTILL_NS: i64 = 90_000_000_000;

impl Run {
    /// A timed run ends when its tracker says that the last pose has gone out, or a moment after that should have been.
    pub(crate) fn time_is_up(&self) -> bool {
        let (Some(began), Some(duration), false) = (self.began_ns, self.options.duration, self.options.simulated_time)
        else {
            return false;
        };
        let over = self.clock().now_ns() - (began + clock::ns(duration));
        match self.has_foreign_poses() {
            true => over >= clock::ns(ON_ITS_WAY),
            false => over >= 0 && (self.tracker_is_done || over > clock::ns(GRACE)),
        }
    }

    /// Whether another program or machine publishes the poses, which goes on when this run ends.
    fn has_foreign_poses(&self) -> bool {
        matches!(self.scene.tracker.source, TrackerSource::External) || self.options.remote.is_some()
    }

    /// Whether a pose of another program or machine came when the time was over: it goes on beyond it.
    pub(crate) fn is_beyond(&self, pose: &ToolPose) -> bool {
        let since_ns = |began_ns| pose.t_publish_ns.saturating_sub(began_ns);
        self.has_foreign_poses()
            && self
                .began_ns
                .is_some_and(|began_ns| self.context.is_beyond(since_ns(began_ns)))
    }

    /// In simulated time nothing goes on until the pilot has taken what went out.
    pub(crate) fn tell_taken(&mut self) -> Result<(), BusError> {
        let Some(taken) = &self.ports.taken else { return Ok(()) };
        let seq = self.metrics.newest_pose().map(|pose| pose.seq);
        let now_ns = self.bus.clock().now_ns();
        if self.newest_came.0 != seq {
            self.newest_came = (seq, now_ns);
        }
        let counters = Counters {
            published: seq.map_or(0, |seq| seq.saturating_add(1)),
            ..Counters::default()
        };
        taken.send(Heartbeat::new(ProcessState::Ready, now_ns, counters, ""))
    }

    /// In simulated time each pose waits for everybody. A process that is restarted holds it up for as long as it may start, and
    /// one that is silent for as long as it may be; a longer wait has no end.
    pub(crate) fn simulated_time_stands_still(&self) -> bool {
        let limits = &self.scene.limits;
        let longest_ns = clock::ns(limits.start)
            .saturating_add(clock::ns(limits.silent))
            .saturating_add(STANDSTILL_NS);
        let since_ns = self.began_ns.unwrap_or(i64::MAX).max(self.newest_came.1);
        self.options.simulated_time && self.clock().now_ns().saturating_sub(since_ns) > longest_ns
    }
}
