//! Finding places in the recording: one that was asked for, and the pose before the one that is shown.

use bus::clock::monotonic_ns;
use bus::message::ProcessState;
use bus::process::Process;

use super::{ReplayError, Replayer};
use crate::replay::lead::{FARTHEST_NS, Judge, MARGIN_NS, WIDER};
use crate::replay::tape::Moment;
use crate::replay::transport::Control;

/// Poses passed over between two signs of life.
const PASSED: usize = 4096;

impl Replayer<'_> {
    /// What shows the pose before the one that is shown, or that one again where there is none before it.
    pub(super) fn step_back(&mut self) -> Result<Control, ReplayError> {
        let first_ns = self.options.span_ns[0];
        let shown_ns = self.last.map_or(first_ns, |pose| pose.t_publish_ns);
        let before_ns = self.tape.before(shown_ns)?.filter(|ns| *ns >= first_ns);
        // The search has moved the tape: who stays where she is goes there again.
        Ok(Control::Show(before_ns.unwrap_or(shown_ns)))
    }

    /// Goes to the first pose that is due at `at_ns` or later; to the last one of what is replayed where there is none. Tells what
    /// that pose goes on from.
    pub(super) fn find(&mut self, at_ns: i64, process: &mut Process) -> Result<(), ReplayError> {
        self.lockstep.forget();
        self.unpictured = None;
        self.choices.jump(at_ns);
        let last_ns = self.options.span_ns[1];
        let mut place_ns = at_ns;
        self.go_to(at_ns, process)?;
        if self.tape.peek().is_none_or(|next| next.due_ns() > last_ns)
            && let Some(before_ns) = self.tape.before(last_ns.saturating_add(1))?
        {
            self.go_to(before_ns, process)?;
            // What is published before the place that the clock shows is not drawn.
            place_ns = at_ns.min(before_ns);
        }
        // The time that it took is not part of the replay.
        self.transport.found(place_ns, monotonic_ns());
        self.tell()?;
        // Frames of emitters are judged by the tracker that makes poses of them, from the first on.
        if self.options.frames.is_none() {
            for pose in self.judge.told() {
                self.outlet.send(&Moment {
                    pose,
                    frame: None,
                    truths: Vec::new(),
                    images: Vec::new(),
                    tissue: None,
                })?;
            }
        }
        Ok(())
    }

    /// Goes to the first pose that is due at `at_ns` or later, and judges what came before it: from so long before it on that it is
    /// known for how long the measurement has stood still.
    fn go_to(&mut self, at_ns: i64, process: &mut Process) -> Result<(), ReplayError> {
        let frozen_ns = self.frozen_ns;
        let Some(limit_ns) = frozen_ns.filter(|_| self.options.frames.is_none()) else {
            self.judge = Judge::new(frozen_ns, self.options.frames.is_some());
            return self.pass_to(at_ns, at_ns, process);
        };
        let captures = self.tape.session().span_ns();
        let first_ns = captures.map_or(0, |(first_ns, _)| i64::try_from(first_ns).unwrap_or(i64::MAX));
        let mut back_ns = limit_ns.saturating_add(MARGIN_NS);
        loop {
            let from_ns = at_ns.saturating_sub(back_ns);
            self.judge = Judge::new(frozen_ns, from_ns <= first_ns);
            self.pass_to(from_ns, at_ns, process)?;
            let next = self.tape.peek().map(|next| &next.pose);
            if next.is_none() || self.judge.is_known(next) || process.stop.is_set() {
                return Ok(());
            }
            if back_ns >= FARTHEST_NS {
                // Nobody is told of a beginning that is not known to be one.
                self.judge = Judge::new(frozen_ns, false);
                return Ok(());
            }
            back_ns = back_ns.saturating_mul(WIDER).min(FARTHEST_NS);
        }
    }

    /// What is due before `at_ns` is passed over, and judged from about `from_ns` on.
    fn pass_to(&mut self, from_ns: i64, at_ns: i64, process: &mut Process) -> Result<(), ReplayError> {
        self.tape.near(from_ns)?;
        let mut passed = 0_usize;
        while self.tape.peek().is_some_and(|next| next.due_ns() < at_ns) && !process.stop.is_set() {
            if let Some(moment) = self.tape.take()
                && self.options.frames.is_none()
            {
                self.judge.take(&moment.pose);
            }
            passed += 1;
            if passed.is_multiple_of(PASSED) {
                process.beat(ProcessState::Ready, "looking for the place in the recording")?;
            }
        }
        Ok(())
    }
}
