//! Finding places in the recording: one that was asked for, and the pose before the one that is shown.

use bus::clock::monotonic_ns;
use bus::message::ProcessState;
use bus::process::Process;

use super::{ReplayError, Replayer};
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

    /// Goes to the first pose that is due at `at_ns` or later; to the last one of what is replayed where there is none.
    pub(super) fn find(&mut self, at_ns: i64, process: &mut Process) -> Result<(), ReplayError> {
        self.lockstep.forget();
        self.unpictured = None;
        self.choices.jump(at_ns);
        let last_ns = self.options.span_ns[1];
        self.pass_to(at_ns, process)?;
        if self.tape.peek().is_none_or(|next| next.due_ns() > last_ns)
            && let Some(before_ns) = self.tape.before(last_ns.saturating_add(1))?
        {
            self.pass_to(before_ns, process)?;
        }
        // The time that it took is not part of the replay.
        self.transport.found(at_ns, monotonic_ns());
        self.tell()?;
        Ok(())
    }

    /// What is due before `at_ns` is passed over.
    fn pass_to(&mut self, at_ns: i64, process: &mut Process) -> Result<(), ReplayError> {
        self.tape.near(at_ns)?;
        let mut passed = 0_usize;
        while self.tape.peek().is_some_and(|next| next.due_ns() < at_ns) && !process.stop.is_set() {
            self.tape.take();
            passed += 1;
            if passed.is_multiple_of(PASSED) {
                process.beat(ProcessState::Ready, "looking for the place in the recording")?;
            }
        }
        Ok(())
    }
}
