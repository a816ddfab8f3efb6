//! Frames of markers on the bus: numbered, with the time of their capture, and what is known of each marker.

use std::thread;
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{CaptureClock, Lost, MarkerFrame, MarkerSight, ToolPose};
use bus::port::{Publisher, Subscriber};
use bus::process::Process;
use bus::topic::{MARKERS, TOOL_POSE};

use crate::clocks::Captured;
use crate::driver::Frame;

/// How long the newest pose is waited for, and between two looks.
const PATIENCE: Duration = Duration::from_millis(150);
const LOOK: Duration = Duration::from_millis(5);

/// Where frames go.
pub(crate) struct Output {
    frames: Publisher<MarkerFrame>,
    device: String,
    markers: Vec<u32>,
    next_seq: u64,
    /// When each marker was seen last, ns.
    seen_ns: Vec<Option<i64>>,
}

impl Output {
    /// Frames of `markers` of the localizer `device`. Numbers go on from the newest pose of the run, so that a process that was started
    /// again does not begin anew.
    pub(crate) fn open(process: &Process, device: &str, markers: Vec<u32>) -> Result<Self, BusError> {
        let poses = Subscriber::<ToolPose>::open(&process.bus, &TOOL_POSE, "", 1)?;
        let mut newest = None;
        // The tracker hands its newest pose on when it looks up next.
        let until_ns = process.clock().now_ns().saturating_add(clock::ns(PATIENCE));
        while newest.is_none() && process.clock().now_ns() < until_ns {
            newest = poses.newest()?.map(|pose| pose.seq);
            thread::sleep(LOOK);
        }
        Ok(Self {
            frames: Publisher::open(&process.bus, &MARKERS, "")?,
            device: device.to_owned(),
            seen_ns: vec![None; markers.len()],
            markers,
            next_seq: newest.map_or(0, |seq| seq.saturating_add(1)),
        })
    }

    /// Publishes a frame. A marker that is not in it was not seen at that instant.
    pub(crate) fn send(&mut self, frame: &Frame, captured: Captured, process: &mut Process) -> Result<(), BusError> {
        let mut sights = Vec::with_capacity(self.markers.len());
        for (&marker, seen_ns) in self.markers.iter().zip(&mut self.seen_ns) {
            let seen = frame.seen.iter().find(|seen| seen.marker == marker);
            let sight = match seen.map_or(Err(Lost::NotSeen), |seen| seen.outcome) {
                Ok((pose, error_mm)) => {
                    *seen_ns = Some(captured.at_ns);
                    MarkerSight::seen(marker, pose, error_mm)
                }
                Err(reason) => MarkerSight::lost(marker, reason, age_ns(*seen_ns, captured.at_ns)),
            };
            sights.push(sight);
        }
        self.publish(frame.device_ns, frame.arrival_ns, captured, &sights, process)
    }

    /// Publishes that nothing is measured now, as there is no connection.
    pub(crate) fn disconnected(&mut self, now_ns: i64, process: &mut Process) -> Result<(), BusError> {
        let lost = |(&marker, seen_ns): (&u32, &Option<i64>)| {
            MarkerSight::lost(marker, Lost::Disconnected, age_ns(*seen_ns, now_ns))
        };
        let sights: Vec<MarkerSight> = self.markers.iter().zip(&self.seen_ns).map(lost).collect();
        let captured = Captured {
            at_ns: now_ns,
            uncertain_ns: 0,
            clock: CaptureClock::Arrival,
        };
        self.publish(0, now_ns, captured, &sights, process)
    }

    fn publish(
        &mut self,
        t_device_ns: i64,
        t_arrival_ns: i64,
        captured: Captured,
        sights: &[MarkerSight],
        process: &mut Process,
    ) -> Result<(), BusError> {
        let mut message = MarkerFrame {
            seq: self.next_seq,
            t_device_ns,
            t_capture_ns: captured.at_ns,
            t_arrival_ns,
            t_uncertain_ns: captured.uncertain_ns,
            clock: captured.clock.code(),
            ..MarkerFrame::EMPTY
        }
        .of_device(&self.device);
        // Never more than the scene names, which a frame has room for.
        if message.set(sights).is_err() {
            process.counters.refused += 1;
            return Ok(());
        }
        message.t_publish_ns = process.clock().now_ns();
        self.frames.send(message)?;
        self.next_seq += 1;
        process.counters.published += 1;
        process.counters.lost += u64::from(sights.first().is_none_or(|sight| sight.status != 0));
        Ok(())
    }
}

fn age_ns(seen_ns: Option<i64>, at_ns: i64) -> i64 {
    seen_ns.map_or(MarkerSight::NEVER, |seen_ns| at_ns.saturating_sub(seen_ns).max(0))
}
