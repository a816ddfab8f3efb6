//! The tracker's process: one sample after the other, on time.

use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{ProcessState, ToolPose, Tracked};
use bus::port::{Publisher, SharedVolume, VolumeSubscriber};
use bus::process::{JoinError, Membership, Process};
use bus::scene::{TrackerSource, TrackerSpec};
use bus::topic::{GROUND_TRUTH, TOOL_POSE};

use crate::follow::follow;
use crate::gesture::{Gesture, GestureError, aim};
use crate::operating_room::{RoomError, ScriptError};
use crate::simulated::{Measured, Simulated};

/// The process looks up at least this often, to be stopped and to give signs of life.
pub(crate) const LOOK_UP: Duration = Duration::from_millis(20);
/// A process that was held up publishes what it missed up to this age; older samples are left out, as a gap in the
/// sequence numbers.
pub(crate) const CATCH_UP: Duration = Duration::from_millis(50);

/// Why the tracker ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// It could not join the run.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The gesture cannot be played.
    #[error(transparent)]
    Gesture(#[from] GestureError),
    /// The simulated operating room cannot be set up.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// Its gesture cannot be played.
    #[error(transparent)]
    Script(#[from] ScriptError),
    /// Poses come from elsewhere.
    #[error(
        "the scene says tracker.source = \"external\": another program publishes the poses, and no tracker is to be started"
    )]
    External,
}

/// Publishes poses until asked to stop; `start_ns` is the moment of sample 0 on the run's clock.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(membership: &Membership, start_ns: i64) -> Result<(), RunError> {
    let mut process = Process::join("tracker", membership)?;
    let output = Output {
        poses: Publisher::open(&process.bus, &TOOL_POSE, "")?,
        truths: Publisher::open(&process.bus, &GROUND_TRUTH, "")?,
        registration_id: process.scene.registration_id(),
        tracker: process.scene.tracker.clone(),
        start_ns,
    };
    if let TrackerSource::OperatingRoom(room) = &output.tracker.source {
        let room = room.clone();
        return follow(&mut process, &output, &room);
    }
    let Some(simulated) = simulated(&mut process)? else {
        return Ok(());
    };
    // A process that starts while the script is going on begins with the next sample: those before it may have been
    // published by its predecessor.
    let mut next = simulated
        .due(process.clock().now_ns() - start_ns)
        .map_or(0, |seq| seq + 1);
    while !process.stop.is_set() {
        process.beat(ProcessState::Ready, "")?;
        let now = process.clock().now_ns() - start_ns;
        next = next.max(simulated.due(now - clock::ns(CATCH_UP)).map_or(0, |seq| seq + 1));
        if simulated.due(now).is_some_and(|due| due >= next) {
            output.publish(next, &simulated, &mut process)?;
            next += 1;
        } else {
            let due_ns = start_ns + simulated.t_device_ns(next);
            let look_up = process.clock().now_ns() + clock::ns(LOOK_UP);
            process.clock().sleep_until(due_ns.min(look_up));
        }
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// The simulated localizer; `None` where the process was stopped while it waited for the volume.
fn simulated(process: &mut Process) -> Result<Option<Simulated>, RunError> {
    let scene = process.scene.clone();
    let TrackerSource::Simulated(simulation) = scene.tracker.source else {
        return Err(RunError::External);
    };
    let approach = &simulation.approach;
    let target = aim(approach, &scene.targets).map(|t| t.centre);
    let gesture = if let (Some(target), Some(_)) = (target, approach.entry) {
        Gesture::new(approach, target, None)?
    } else {
        let Some(volume) = volume(process)? else {
            return Ok(None);
        };
        let target = target.unwrap_or_else(|| volume.grid().centre());
        Gesture::new(approach, target, Some(volume.grid()))?
    };
    Ok(Some(Simulated::new(
        gesture,
        simulation,
        &scene.tracker.ct_from_tracker,
        scene.seed,
        scene.tracker.rate_hz,
    )))
}

/// The volume, waited for; `None` where the process was stopped in the meantime.
pub(crate) fn volume(process: &mut Process) -> Result<Option<SharedVolume>, RunError> {
    let volumes = VolumeSubscriber::open(&process.bus)?;
    loop {
        if process.stop.is_set() {
            return Ok(None);
        }
        process.beat(ProcessState::Starting, "waiting for the volume")?;
        match volumes.poll()? {
            Some(volume) => return Ok(Some(volume)),
            None => std::thread::sleep(LOOK_UP),
        }
    }
}

/// Where samples go.
pub(crate) struct Output {
    pub(crate) poses: Publisher<ToolPose>,
    pub(crate) truths: Publisher<ToolPose>,
    pub(crate) registration_id: u64,
    tracker: TrackerSpec,
    pub(crate) start_ns: i64,
}

impl Output {
    fn publish(&self, seq: u64, simulated: &Simulated, process: &mut Process) -> Result<(), RunError> {
        let measured = simulated.sample(seq);
        let mut pose = self.message(seq, &measured, process);
        pose.covariance = simulated.covariance();
        pose.set(measured.tracked(&self.tracker.ct_from_tracker));
        let mut truth = self.message(seq, &measured, process);
        truth.set(Tracked::Valid(measured.truth));
        self.poses.send(pose)?;
        self.truths.send(truth)?;
        process.counters.published += 1;
        process.counters.lost += u64::from(measured.tracker_from_tool.is_err());
        Ok(())
    }

    fn message(&self, seq: u64, measured: &Measured, process: &Process) -> ToolPose {
        ToolPose {
            seq,
            t_device_ns: measured.t_device_ns,
            t_capture_ns: self.start_ns + measured.t_device_ns,
            t_publish_ns: process.clock().now_ns(),
            registration_id: self.registration_id,
            ..ToolPose::EMPTY
        }
    }
}
