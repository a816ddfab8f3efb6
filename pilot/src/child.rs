//! A process of a run, as the pilot holds it.

use bus::message::{Heartbeat, ProcessState};

use crate::plan::Planned;
use crate::spawn::Running;
use crate::supervise::KillReason;

/// A process that the scene asks for, whether it runs or not.
#[derive(Debug)]
pub(crate) struct Child {
    pub(crate) planned: Planned,
    /// What was started, while it has not ended.
    pub(crate) running: Option<Running>,
    /// What it said of itself last.
    pub(crate) note: String,
    /// For how long its work has said nothing: a disk may make a recorder wait.
    pub(crate) standstill: Standstill,
    /// Why it was killed, so that its ending can say so.
    pub(crate) kill_cause: Option<KillReason>,
    /// It ended too often and is left alone.
    pub(crate) is_held: bool,
}

impl Child {
    /// Nothing was started yet.
    pub(crate) fn new(planned: Planned) -> Self {
        Self {
            planned,
            running: None,
            note: String::new(),
            standstill: Standstill::default(),
            kill_cause: None,
            is_held: false,
        }
    }

    /// Its name in the run.
    pub(crate) fn name(&self) -> &str {
        &self.planned.name
    }
}

/// For how long the work of a process has said nothing, while another thread of it may have given signs of life.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Standstill {
    /// When it spoke last; `None`: it has not yet, or is ending.
    last_ns: Option<i64>,
    pub(crate) longest_ns: i64,
}

impl Standstill {
    /// Its work has spoken. One that is ending may take its time.
    pub(crate) fn heard(&mut self, beat: &Heartbeat) {
        self.ended(beat.t_ns);
        self.last_ns = (beat.process_state() != ProcessState::Stopping).then_some(beat.t_ns);
    }

    /// It says nothing more: a standstill that nobody saw the end of counts too.
    pub(crate) fn ended(&mut self, now_ns: i64) {
        self.longest_ns = self.longest_ns.max(self.so_far_ns(now_ns));
        self.last_ns = None;
    }

    /// For how long it has said nothing by now.
    pub(crate) fn so_far_ns(&self, now_ns: i64) -> i64 {
        self.last_ns.map_or(0, |last_ns| now_ns.saturating_sub(last_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::Counters;

    #[test]
    fn a_standstill_that_nobody_saw_the_end_of_counts_and_an_ending_is_none() {
        let beat = |state, t_ns| Heartbeat::new(state, t_ns, Counters::default(), "");
        let mut work = Standstill::default();
        assert_eq!(work.so_far_ns(1_000), 0, "it has not spoken yet");
        work.heard(&beat(ProcessState::Ready, 100));
        work.heard(&beat(ProcessState::Ready, 350));
        assert_eq!((work.longest_ns, work.so_far_ns(400)), (250, 50));
        work.ended(5_350);
        assert_eq!((work.longest_ns, work.so_far_ns(9_000)), (5_000, 0));
        work.heard(&beat(ProcessState::Stopping, 10_000));
        work.ended(90_000);
        assert_eq!(work.longest_ns, 5_000);
    }
}
