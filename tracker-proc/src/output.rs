//! Where poses go and when, the same for every source of them.

use std::cell::Cell;
use std::time::Duration;

use bus::clock;
use bus::message::{ProcessState, ToolPose};
use bus::port::{Publisher, SharedVolume, VolumeSubscriber};
use bus::process::Process;
use bus::topic::TOOL_POSE;
use scene::Scene;

use crate::run_error::RunError;

/// The process looks up at least this often, to be stopped and to give signs of life.
pub(crate) const LOOK_UP: Duration = Duration::from_millis(20);
/// A process that was held up publishes what it missed up to half the age at which an image is old; older samples are left out,
/// as a gap in the sequence numbers.
pub(crate) fn catch_up_ns(scene: &Scene) -> i64 {
    clock::ns(scene.limits.stale) / 2
}

/// The last sample of the time that the run navigates for has gone out.
pub(crate) const OVER: &str = "the time is over";

/// Between two looks whether the navigation has begun.
const BEGINNING: Duration = Duration::from_millis(5);

/// The volume, waited for; `None` where the process was stopped in the meantime.
pub(crate) fn volume(process: &mut Process, volumes: &VolumeSubscriber) -> Result<Option<SharedVolume>, RunError> {
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

/// Where poses go.
pub(crate) struct Output {
    pub(crate) poses: Publisher<ToolPose>,
    /// Of the scene's own numbers.
    pub(crate) registration_id: u64,
    start_ns: Cell<Option<i64>>,
    /// In simulated time: what was due until then has been published by a tracker before this one.
    pub(crate) after_ns: Option<i64>,
}

/// When sample 0 is due.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) at_ns: i64,
    /// Whether no tracker of the run has published before.
    pub(crate) is_first: bool,
}

impl Output {
    /// Opens the topic; `start_ns` is the moment of sample 0 where that was said when this process was started.
    pub(crate) fn open(process: &Process, start_ns: Option<i64>, after_ns: Option<i64>) -> Result<Self, RunError> {
        Ok(Self {
            poses: Publisher::open(&process.bus, &TOOL_POSE, "")?,
            registration_id: process.scene.registration_id(),
            start_ns: Cell::new(start_ns),
            after_ns,
        })
    }

    /// Waits until the pilot says when the navigation begins, unless that was said when this process was started; `None` where
    /// it was stopped meanwhile.
    pub(crate) fn start(&self, process: &mut Process) -> Result<Option<Start>, RunError> {
        if let Some(at_ns) = self.start_ns.get() {
            let is_first = false;
            return Ok(Some(Start { at_ns, is_first }));
        }
        while !process.stop.is_set() {
            process.beat(ProcessState::Ready, "")?;
            if let Some(at_ns) = process.run.began_ns() {
                self.start_ns.set(Some(at_ns));
                let is_first = true;
                return Ok(Some(Start { at_ns, is_first }));
            }
            std::thread::sleep(BEGINNING);
        }
        Ok(None)
    }

    /// Whether a frame captured at `t_capture_ns` is beyond the time that the run navigates for.
    pub(crate) fn is_beyond(&self, process: &Process, t_capture_ns: i64) -> bool {
        if process.run.duration_ns.is_none() {
            return false;
        }
        if self.start_ns.get().is_none() {
            self.start_ns.set(process.run.began_ns());
        }
        let start_ns = self.start_ns.get();
        start_ns.is_some_and(|start_ns| process.run.is_beyond(t_capture_ns.saturating_sub(start_ns)))
    }

    /// When sample 0 was due, ns on the run's clock.
    pub(crate) fn start_ns(&self) -> i64 {
        self.start_ns.get().unwrap_or(0)
    }
}
