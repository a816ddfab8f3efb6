//! Which samples lead to the place that a replay went to.

use super::Session;

/// What a process has seen of the places that a replay went to.
///
/// A replayer publishes the last samples before a place too, so that what comes there is judged as it was when it was recorded; they are
/// shown by nobody.
#[derive(Debug, Clone, Copy)]
pub struct Lead {
    /// A replay begins, or has gone elsewhere, and nothing of the place has come.
    leads: bool,
    /// It has gone elsewhere while this process looked on.
    has_jumped: bool,
}

impl Default for Lead {
    /// Of a replay of which nothing has come.
    fn default() -> Self {
        Self {
            leads: true,
            has_jumped: false,
        }
    }
}

impl Lead {
    /// The replay has gone elsewhere.
    pub fn jumped(&mut self) {
        (self.leads, self.has_jumped) = (true, true);
    }

    /// A sample of the place itself has come.
    pub fn came(&mut self) {
        self.leads = false;
    }

    /// Whether the place lies behind what was published at `t_publish_ns` on the clock of `session`. Never so in a run that is no replay.
    pub fn is_before_the_place(&self, session: &Session, t_publish_ns: i64) -> bool {
        let law = session.replay().filter(|_| self.leads && session.is_replay());
        // Who comes late to a replay that stands still finds the clock behind the pose that is shown.
        law.is_some_and(|law| t_publish_ns < if self.has_jumped { law.anchor_ns } else { law.first_ns })
    }
}
