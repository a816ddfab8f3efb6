//! What a person chose in the run that was recorded, told again at its time.

use bus::message::Guide;

/// So many that were said before a place are told when a replay goes there: a pose that was captured before it shows what was chosen
/// then. As many as the bus keeps for who joins late.
const BEFORE: usize = 64;

/// The guides of a recording, in the order of their stamps, and which of them is told next.
#[derive(Debug, Default)]
pub struct Choices {
    all: Vec<Guide>,
    next: usize,
    /// Nothing was chosen yet where the replay went, ns on the recorded run's clock, and something was told.
    none_at_ns: Option<i64>,
    has_told: bool,
}

impl Choices {
    /// Those of a recording. Of several with one stamp the last counts, as it did then.
    pub fn new(mut all: Vec<Guide>) -> Self {
        all.sort_by_key(|guide| guide.t_ns);
        all.reverse();
        all.dedup_by_key(|guide| guide.t_ns);
        all.reverse();
        Self { all, ..Self::default() }
    }

    /// The replay goes to `at_ns`: what was chosen there is told again.
    pub fn jump(&mut self, at_ns: i64) {
        let said = self.all.partition_point(|guide| guide.t_ns <= at_ns);
        self.next = said.saturating_sub(BEFORE);
        self.none_at_ns = (said == 0 && self.has_told).then_some(at_ns);
    }

    /// What was chosen at `t_ns`.
    pub fn at(&self, t_ns: i64) -> Option<&Guide> {
        let said = self.all.partition_point(|guide| guide.t_ns <= t_ns);
        said.checked_sub(1).and_then(|last| self.all.get(last))
    }

    /// What is to be told by `now_ns` and was not yet, in order.
    pub fn due(&mut self, now_ns: i64) -> Vec<Guide> {
        let until = self.all.partition_point(|guide| guide.t_ns <= now_ns);
        let none = self.none_at_ns.take().map(|t_ns| Guide {
            t_ns,
            ..Guide::default()
        });
        let first = self.next.min(until);
        let due: Vec<Guide> = none.into_iter().chain(self.all[first..until].iter().copied()).collect();
        self.next = self.next.max(until);
        self.has_told |= !due.is_empty();
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guide(t_ns: i64, plan_id: u64) -> Guide {
        Guide {
            t_ns,
            plan_id,
            ..Guide::default()
        }
    }

    fn due(choices: &mut Choices, now_ns: i64) -> Vec<(i64, u64)> {
        choices
            .due(now_ns)
            .iter()
            .map(|guide| (guide.t_ns, guide.plan_id))
            .collect()
    }

    #[test]
    fn each_is_told_once_at_its_time() {
        let mut choices = Choices::new(vec![guide(0, 1), guide(100, 2), guide(200, 3)]);
        assert_eq!(due(&mut choices, -1), []);
        assert_eq!(due(&mut choices, 99), [(0, 1)]);
        assert_eq!(due(&mut choices, 99), []);
        assert_eq!(due(&mut choices, 500), [(100, 2), (200, 3)]);
        // A clock that goes back without a jump tells nothing.
        assert_eq!(due(&mut choices, 50), []);
        assert_eq!(due(&mut choices, i64::MAX), []);
    }

    #[test]
    fn where_a_replay_goes_it_tells_what_was_chosen_there() {
        let mut choices = Choices::new(vec![guide(100, 2), guide(200, 3)]);
        choices.jump(150);
        assert_eq!(due(&mut choices, 160), [(100, 2)]);
        choices.jump(500);
        assert_eq!(due(&mut choices, 500), [(100, 2), (200, 3)]);
        // Before the first: nothing was chosen, and that is told.
        choices.jump(50);
        assert_eq!(due(&mut choices, 60), [(50, 0)]);
        assert_eq!(due(&mut choices, 100), [(100, 2)]);
        let mut fresh = Choices::new(vec![guide(100, 2)]);
        fresh.jump(50);
        assert_eq!(due(&mut fresh, 60), []);
    }

    #[test]
    fn a_jump_tells_no_more_than_the_bus_keeps() {
        let all = (0..1000).map(|i| guide(i, i.unsigned_abs())).collect();
        let mut choices = Choices::new(all);
        choices.jump(900);
        let told = due(&mut choices, 900);
        assert_eq!(
            (told.len(), told.first(), told.last()),
            (BEFORE, Some(&(837, 837)), Some(&(900, 900)))
        );
    }

    /// A recorder that was started again writes down once more what it is given as history.
    #[test]
    fn what_was_written_twice_is_told_once_and_the_last_of_one_stamp_counts() {
        let mut choices = Choices::new(vec![guide(0, 1), guide(100, 2), guide(0, 1), guide(100, 3)]);
        assert_eq!(due(&mut choices, 100), [(0, 1), (100, 3)]);
    }
}
