//! A pose with all that goes with it on the bus, and its pictures.

use std::time::Duration;

use bus::BusError;
use bus::clock::{self, monotonic_ns};
use bus::lockstep::TRACKER;
use bus::message::{ProcessState, ReplayState};
use bus::process::Process;

use super::{ReplayError, Replayer};
use crate::replay::Speed;
use crate::replay::transport::Control;

/// How long the tracker may take for a pose, a restart of it included.
const MAKING: Duration = Duration::from_secs(10);

impl Replayer<'_> {
    /// Tells what a person had chosen by `now_ns`.
    pub(super) fn choose(&mut self, now_ns: i64) -> Result<(), BusError> {
        self.choices
            .due(now_ns)
            .into_iter()
            .try_for_each(|guide| self.guides.send(guide))
    }

    /// Everybody must know the clock before the pose that it holds for.
    pub(super) fn tell(&mut self) -> Result<(), BusError> {
        let law = self.transport.message(self.judged_from_ns);
        if self.told != Some(law) {
            self.laws.send(law)?;
            self.told = Some(law);
        }
        Ok(())
    }

    pub(super) fn publish(&mut self, process: &Process) -> Result<(), ReplayError> {
        let Some(moment) = self.tape.take() else { return Ok(()) };
        let is_unknown = self.asked.is_some() && moment.tissue.is_none();
        if is_unknown || !self.outlet.takes(&moment) {
            let counted = match is_unknown {
                true => &mut self.without_state,
                false => &mut self.without_frames,
            };
            *counted += 1;
            if self.transport.state() == ReplayState::Paused {
                // Who asked for the next pose is shown the next that there is.
                self.transport.control(Control::Step, monotonic_ns());
            }
            return Ok(());
        }
        if self.options.frames.is_none() {
            self.judge.take(&moment.pose);
            if self.judged_from_ns == i64::MAX && self.judge.is_known(Some(&moment.pose)) {
                self.judged_from_ns = moment.pose.t_publish_ns;
                self.tell()?;
            }
        }
        let waits = self.transport.speed() == Speed::Max || self.transport.state() == ReplayState::Paused;
        if waits {
            self.lockstep.expect(moment.pose.seq, moment.pose.t_capture_ns)?;
            self.unpictured = Some(moment.pose);
        } else if let Some(when) = self.transport.law().when(moment.due_ns()) {
            self.timing.saw(monotonic_ns().saturating_sub(when));
        }
        self.choose(moment.due_ns())?;
        // Before its pose: who draws that has it then.
        if let (Some(organs), Some(state)) = (&mut self.organs, &moment.tissue) {
            organs.send(state)?;
        }
        if let (Some(asked), Some(state)) = (&self.asked, &moment.tissue) {
            asked.send(state.header)?;
        }
        self.outlet.send(&moment)?;
        for truth in &moment.truths {
            self.truths.send(*truth)?;
        }
        self.images_of_probe.send(&process.bus, &moment.images)?;
        self.published += 1;
        self.published_ns = monotonic_ns();
        self.last = Some(moment.pose);
        Ok(())
    }

    /// Whether something is made again of what is replayed: in order, as it was then.
    pub(super) fn makes_again(&self) -> bool {
        self.options.frames.is_some() || self.asked.is_some()
    }

    /// A tracker that has made no pose of a frame for long will not make one: the replay goes on without.
    pub(super) fn lose_patience(&mut self) {
        if self.lockstep.missing() != Some(TRACKER) || monotonic_ns() - self.published_ns < clock::ns(MAKING) {
            return;
        }
        if self.unanswered == 0 {
            let seq = self.last.map_or(0, |pose| pose.seq);
            bus::stderr_line!(
                "replay: the tracker makes no pose of frame {seq}; this and further ones are only counted"
            );
        }
        self.unanswered += 1;
        self.unpictured = None;
        self.lockstep.forget();
    }

    /// Pictures are taken of poses that every view has drawn.
    pub(super) fn picture(&mut self, process: &mut Process) -> Result<(), ReplayError> {
        // Where poses are made again, it is the new one.
        let Some(recorded) = self.unpictured.take() else {
            return Ok(());
        };
        let pose = self.lockstep.made().unwrap_or(recorded);
        if self.options.frames.is_some() {
            self.judge.take(&pose);
        }
        let (pose, _) = self.judge.judged(pose);
        let Some(images) = &mut self.images else { return Ok(()) };
        images.pose(&pose, &mut || process.beat(ProcessState::Ready, "taking pictures"))?;
        Ok(())
    }
}
