//! A process of a run, as the pilot holds it.

use bus::message::{GPU_GIVEN_UP, Heartbeat, ProcessState, may_be_older_ms};

use crate::plan::{LOCALIZER, Planned};
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

    /// Whether it says that its graphics card is used no more: a renderer alone knows that, whatever others quote.
    pub(crate) fn has_given_up_a_card(&self, note: &str) -> bool {
        !self.planned.views.is_empty() && note.contains(GPU_GIVEN_UP)
    }

    /// By how much it says that poses may be older than they look, ms: a localizer alone knows that.
    pub(crate) fn older_ms(&self, note: &str) -> Option<u64> {
        may_be_older_ms(note).filter(|_| self.name() == LOCALIZER)
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

    /// For so long nobody listened: what was not heard meanwhile is no standstill.
    pub(crate) fn forgive(&mut self, absent_ns: i64) {
        self.last_ns = self.last_ns.map(|last_ns| last_ns.saturating_add(absent_ns));
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
    use crate::supervise::Role;
    use bus::message::{Counters, MAY_BE_OLDER};

    fn child(name: &str, views: &[usize]) -> Child {
        Child::new(Planned {
            name: name.to_owned(),
            binary: "",
            arguments: Vec::new(),
            role: Role {
                after: Vec::new(),
                stop_rank: 0,
            },
            views: views.to_vec(),
        })
    }

    /// A device whose VER was "GPU given up, ..." gave up a card, and a client's words could make poses old.
    #[test]
    fn what_one_process_quotes_is_not_taken_for_what_another_one_says() {
        let (localizer, renderer) = (child(LOCALIZER, &[]), child("view-axial", &[0]));
        let (card, old) = (format!("device \"{GPU_GIVEN_UP} x\""), format!("{MAY_BE_OLDER}9999"));
        assert!(renderer.has_given_up_a_card(&card) && !localizer.has_given_up_a_card(&card));
        assert_eq!((localizer.older_ms(&old), renderer.older_ms(&old)), (Some(9999), None));
    }

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
    /// The report said that a disk held up the recorder, which had gone on: it was the pilot that had been stopped.
    #[test]
    fn while_the_pilot_stood_still_nobody_else_did() {
        let beat = |t_ns| Heartbeat::new(ProcessState::Ready, t_ns, Counters::default(), "");
        let mut work = Standstill::default();
        work.heard(&beat(100));
        // It spoke at 200, 300 and so on too; the newest is what is found.
        work.forgive(5_000);
        work.heard(&beat(5_090));
        assert_eq!(work.longest_ns, 0);
        work.heard(&beat(5_300));
        assert_eq!(work.longest_ns, 210, "what it does before and after still counts");
    }
}
