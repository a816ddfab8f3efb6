//! Frames of markers, or of single emitters, on the bus: numbered, with the time of their capture.

use std::thread;
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{CaptureClock, EmitterFrame, Lost, MarkerFrame, MarkerSight, ToolPose};
use bus::port::{Publisher, Subscriber};
use bus::process::Process;
use bus::topic::{EMITTERS, MARKERS, TOOL_POSE};

use crate::clocks::Captured;
use crate::driver::{Frame, Places};

/// How long the newest pose is waited for, and between two looks.
const PATIENCE: Duration = Duration::from_millis(150);
const LOOK: Duration = Duration::from_millis(5);

/// Frames of one connection come in their order, and none is so late, ns.
const BEGUN_ANEW_NS: i64 = 1_000_000_000;

/// Where frames go.
pub(crate) struct Output {
    frames: Frames,
    next_seq: u64,
}

enum Frames {
    Markers(Markers),
    Emitters(Publisher<EmitterFrame>, Order),
}

/// The device's time, which goes on where a connection ends and another begins, as frames of emitters have no other order.
#[derive(Debug, Default)]
struct Order {
    /// The newest of a frame, and when that was captured, ns.
    last: Option<(i64, i64)>,
    /// Since that frame the connection was another, or none.
    is_broken: bool,
    /// What is added to a device's time.
    ahead_ns: i64,
}

impl Order {
    /// Of a frame that the device measured at `device_ns`. A device that was started again, or was reset, has an earlier clock than before;
    /// what comes back in time a little is for the tracker to refuse.
    fn measured(&mut self, device_ns: i64, at_ns: i64) -> i64 {
        let mut order_ns = device_ns.saturating_add(self.ahead_ns);
        let back_ns = self.last.map_or(0, |(last_ns, _)| last_ns.saturating_sub(order_ns));
        let is_other = std::mem::take(&mut self.is_broken) || back_ns > BEGUN_ANEW_NS;
        if let Some((last_ns, _)) = self.last.filter(|(last_ns, _)| is_other && order_ns <= *last_ns) {
            order_ns = self.after(at_ns).max(last_ns.saturating_add(1));
            self.ahead_ns = order_ns.saturating_sub(device_ns);
        }
        self.last = Some((order_ns, at_ns));
        order_ns
    }

    /// Of a frame that says that there is no connection.
    fn broken(&mut self, at_ns: i64) -> i64 {
        self.is_broken = true;
        let order_ns = self.after(at_ns);
        self.last = Some((order_ns, at_ns));
        order_ns
    }

    fn after(&self, at_ns: i64) -> i64 {
        self.last.map_or(0, |(last_ns, last_at_ns)| {
            last_ns.saturating_add(at_ns.saturating_sub(last_at_ns).max(1))
        })
    }
}

/// Frames of markers.
struct Markers {
    frames: Publisher<MarkerFrame>,
    device: String,
    markers: Vec<u32>,
    /// When each marker was seen last, ns.
    seen_ns: Vec<Option<i64>>,
}

impl Output {
    /// Frames of `markers` of the localizer `device`.
    pub(crate) fn of_markers(process: &Process, device: &str, markers: Vec<u32>) -> Result<Self, BusError> {
        let frames = Frames::Markers(Markers {
            frames: Publisher::open(&process.bus, &MARKERS, "")?,
            device: device.to_owned(),
            seen_ns: vec![None; markers.len()],
            markers,
        });
        Self::open(process, frames)
    }

    /// Frames of single emitters.
    pub(crate) fn of_emitters(process: &Process) -> Result<Self, BusError> {
        Self::open(
            process,
            Frames::Emitters(Publisher::open(&process.bus, &EMITTERS, "")?, Order::default()),
        )
    }

    /// Numbers go on from the newest pose of the run, so that a process that was started again does not begin anew.
    fn open(process: &Process, frames: Frames) -> Result<Self, BusError> {
        let poses = Subscriber::<ToolPose>::open(&process.bus, &TOOL_POSE, "", 1)?;
        let mut newest = None;
        // The tracker hands its newest pose on when it looks up next.
        let until_ns = process.clock().now_ns().saturating_add(clock::ns(PATIENCE));
        while newest.is_none() && process.clock().now_ns() < until_ns {
            newest = poses.newest()?.map(|pose| pose.seq);
            thread::sleep(LOOK);
        }
        Ok(Self {
            frames,
            next_seq: newest.map_or(0, |seq| seq.saturating_add(1)),
        })
    }

    /// Publishes a frame of markers. Nothing where emitters are published.
    pub(crate) fn send(&mut self, frame: &Frame, captured: Captured, process: &mut Process) -> Result<(), BusError> {
        match &mut self.frames {
            Frames::Markers(markers) => markers.send(frame, captured, &mut self.next_seq, process),
            Frames::Emitters(..) => Ok(()),
        }
    }

    /// Publishes the places of single emitters. Nothing where markers are published.
    pub(crate) fn send_places(
        &mut self,
        device_ns: i64,
        captured: Captured,
        places: &Places,
        process: &mut Process,
    ) -> Result<(), BusError> {
        let Frames::Emitters(_, order) = &mut self.frames else {
            return Ok(());
        };
        let t_device_ns = order.measured(device_ns, captured.at_ns);
        self.put(t_device_ns, captured, places, process)
    }

    fn put(
        &mut self,
        t_device_ns: i64,
        captured: Captured,
        places: &Places,
        process: &mut Process,
    ) -> Result<(), BusError> {
        let Frames::Emitters(frames, _) = &self.frames else {
            return Ok(());
        };
        let mut message = EmitterFrame {
            seq: self.next_seq,
            t_device_ns,
            t_capture_ns: captured.at_ns,
            ..EmitterFrame::EMPTY
        };
        let set = message.set(places.tool.iter().copied(), places.patient.iter().copied());
        // Never more than a definition has.
        if set.is_err() {
            process.counters.refused += 1;
            return Ok(());
        }
        message.t_publish_ns = process.clock().now_ns();
        frames.send(message)?;
        self.next_seq += 1;
        process.counters.published += 1;
        process.counters.lost += u64::from(places.tool.is_empty());
        Ok(())
    }

    /// Publishes that nothing is measured now, as there is no connection.
    pub(crate) fn disconnected(&mut self, now_ns: i64, process: &mut Process) -> Result<(), BusError> {
        let captured = Captured {
            at_ns: now_ns,
            uncertain_ns: 0,
            clock: CaptureClock::Arrival,
            waited_ns: 0,
        };
        match &mut self.frames {
            Frames::Markers(markers) => markers.disconnected(captured, &mut self.next_seq, process),
            // An emitter that is not seen has no reason.
            Frames::Emitters(_, order) => {
                let t_device_ns = order.broken(now_ns);
                self.put(t_device_ns, captured, &Places::default(), process)
            }
        }
    }
}

impl Markers {
    /// Publishes a frame. A marker that is not in it was not seen at that instant.
    fn send(
        &mut self,
        frame: &Frame,
        captured: Captured,
        next_seq: &mut u64,
        process: &mut Process,
    ) -> Result<(), BusError> {
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
        self.publish(
            frame.device_ns,
            frame.arrival_ns,
            captured,
            &sights,
            (next_seq, process),
        )
    }

    fn disconnected(&mut self, captured: Captured, next_seq: &mut u64, process: &mut Process) -> Result<(), BusError> {
        let now_ns = captured.at_ns;
        let lost = |(&marker, seen_ns): (&u32, &Option<i64>)| {
            MarkerSight::lost(marker, Lost::Disconnected, age_ns(*seen_ns, now_ns))
        };
        let sights: Vec<MarkerSight> = self.markers.iter().zip(&self.seen_ns).map(lost).collect();
        self.publish(0, now_ns, captured, &sights, (next_seq, process))
    }

    fn publish(
        &mut self,
        t_device_ns: i64,
        t_arrival_ns: i64,
        captured: Captured,
        sights: &[MarkerSight],
        (next_seq, process): (&mut u64, &mut Process),
    ) -> Result<(), BusError> {
        let mut message = MarkerFrame {
            seq: *next_seq,
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
        *next_seq += 1;
        process.counters.published += 1;
        process.counters.lost += u64::from(sights.first().is_none_or(|sight| sight.status != 0));
        Ok(())
    }
}

fn age_ns(seen_ns: Option<i64>, at_ns: i64) -> i64 {
    seen_ns.map_or(MarkerSight::NEVER, |seen_ns| at_ns.saturating_sub(seen_ns).max(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames without a connection had the device's time 0, and a device that was started again was behind them for ever.
    #[test]
    fn the_order_of_frames_goes_on_over_another_connection() {
        let mut order = Order::default();
        assert_eq!(order.measured(5_000_000_000, 100), 5_000_000_000);
        assert_eq!(order.measured(5_016_000_000, 16_000_100), 5_016_000_000);
        // Within a connection it is the device's, whatever it says.
        assert_eq!(order.measured(5_000_000_000, 32_000_100), 5_000_000_000);
        assert_eq!(order.measured(5_032_000_000, 48_000_100), 5_032_000_000);
        assert_eq!(order.broken(98_000_100), 5_082_000_000);
        assert_eq!(order.broken(98_000_100), 5_082_000_001);
        // Started again, the first frame a second later.
        assert_eq!(order.measured(7, 1_098_000_100), 6_082_000_001);
        assert_eq!(order.measured(16_000_007, 1_114_000_100), 6_098_000_001);
        // The same device again, whose clock went on.
        order.broken(1_200_000_000);
        assert_eq!(order.measured(10_000_000_000, 2_000_000_000), 16_081_999_994);
        // Reset on one connection: its clock begins anew, and goes on from where it was.
        assert_eq!(order.measured(3, 2_010_000_000), 16_091_999_994);
        assert_eq!(order.measured(16_000_003, 2_026_000_000), 16_107_999_994);
        let mut late = Order::default();
        assert_eq!((late.broken(3), late.broken(10), late.measured(9, 11)), (0, 7, 9));
        order.broken(i64::MAX);
        order.measured(i64::MIN, i64::MAX);
    }
}
