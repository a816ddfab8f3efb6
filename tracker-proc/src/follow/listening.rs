//! Frames of a localizer that come over the bus, one after the other: of emitters, or of markers.

use std::ops::ControlFlow;

use bus::BusError;
use bus::message::ProcessState;
use bus::port::{Message, Subscriber};
use bus::process::Process;
use bus::wake::Waits;

use super::{Follower, Stamp, refuse};
use crate::output::{LOOK_UP, OVER};
use crate::run_error::RunError;

/// Frames that may wait while the process is held up, a quarter of a second at 1000 Hz.
pub(super) const DEPTH: usize = 256;

/// Makes poses of the frames of one topic.
pub(super) trait Taker {
    /// What comes over the bus.
    type Frame: Message;

    /// When it was made, or its number and why it is no frame, in words.
    fn stamp(&self, frame: &Self::Frame) -> Result<Stamp, (u64, String)>;

    /// Publishes the pose of a frame that was admitted.
    fn take(
        &mut self,
        frame: &Self::Frame,
        stamp: &Stamp,
        follower: &mut Follower<'_>,
        process: &mut Process,
    ) -> Result<(), RunError>;
}

/// Publishes a pose for each frame until asked to stop.
///
/// # Errors
/// [`RunError`]. A replay without calibration or registration is refused, as it would give nothing but lost poses.
pub(super) fn listen<T: Taker>(
    process: &mut Process,
    frames: &Subscriber<T::Frame>,
    follower: Follower<'_>,
    taker: &mut T,
) -> Result<(), RunError> {
    if let (true, Some(why)) = (process.session.is_replay(), follower.constants.reason()) {
        return Err(RunError::NoLinks(why));
    }
    let mut listening = Listening {
        follower,
        taker,
        next_seq: None,
    };
    Waits::every(LOOK_UP)
        .message(frames, None)
        .run(|| match listening.step(frames, process) {
            Ok(ControlFlow::Continue(())) => ControlFlow::Continue(()),
            Ok(ControlFlow::Break(())) => ControlFlow::Break(Ok(())),
            Err(error) => ControlFlow::Break(Err(error)),
        })?
}

/// The state between two frames.
struct Listening<'a, T> {
    follower: Follower<'a>,
    taker: &'a mut T,
    /// The number that the next frame should have.
    next_seq: Option<u64>,
}

impl<T: Taker> Listening<'_, T> {
    fn step(&mut self, frames: &Subscriber<T::Frame>, process: &mut Process) -> Result<ControlFlow<()>, RunError> {
        if process.stop.is_set() {
            process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(ControlFlow::Break(()));
        }
        while let Some(frame) = frames.next()? {
            // The clock of a replay goes out before the frames for which it holds.
            self.follow_clock(process)?;
            self.frame(&frame, process)?;
        }
        self.follow_clock(process)?;
        self.follower.tend(process);
        self.follower.output.poses.serve_late_joiners();
        match self.follower.output.is_beyond(process, process.clock().now_ns()) {
            true => process.beat(ProcessState::Stopping, OVER)?,
            false => process.beat_with(ProcessState::Ready, || self.follower.words())?,
        }
        Ok(ControlFlow::Continue(()))
    }

    fn follow_clock(&mut self, process: &mut Process) -> Result<(), BusError> {
        if process.session.follow()? {
            self.follower.went_elsewhere();
            self.next_seq = None;
        }
        Ok(())
    }

    fn frame(&mut self, frame: &T::Frame, process: &mut Process) -> Result<(), RunError> {
        let stamp = match self.taker.stamp(frame) {
            Ok(stamp) => stamp,
            Err((seq, why)) => {
                refuse(process, seq, &why);
                return Ok(());
            }
        };
        if self.follower.output.is_beyond(process, stamp.t_capture_ns) || !self.follower.admit(&stamp, process) {
            return Ok(());
        }
        let missed = self.next_seq.map_or(0, |next| stamp.seq.saturating_sub(next));
        process.counters.dropped += missed;
        self.next_seq = stamp.seq.checked_add(1);
        self.taker.take(frame, &stamp, &mut self.follower, process)
    }
}
