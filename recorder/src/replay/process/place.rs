//! Finding places in the recording: one that was asked for, and the pose before the one that is shown.

use bus::clock::monotonic_ns;
use bus::message::ProcessState;
use bus::process::Process;

use super::{ReplayError, Replayer};
use crate::replay::find;
use crate::replay::lead::Judge;
use crate::replay::tape::Moment;
use crate::replay::transport::Control;

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

    /// Goes to the first pose that is due at `at_ns` or later, and judges what came before it, unless poses are made again.
    fn go_to(&mut self, at_ns: i64, process: &mut Process) -> Result<(), ReplayError> {
        let makes_poses = self.options.frames.is_some();
        let limit_ns = self.frozen_ns.filter(|_| !makes_poses);
        let mut failed = Ok(());
        let mut goes_on = || {
            failed = process.beat(ProcessState::Ready, "looking for the place in the recording");
            failed.is_ok() && !process.stop.is_set()
        };
        let judge = find::go_to(&mut self.tape, at_ns, limit_ns, &mut goes_on)?;
        failed?;
        self.judge = match makes_poses {
            true => Judge::new(self.frozen_ns, true),
            false => judge,
        };
        let next = self.tape.peek().map(|next| &next.pose);
        self.judged_from_ns = match self.judge.is_known(next) {
            true => i64::MIN,
            false => i64::MAX,
        };
        Ok(())
    }
}
