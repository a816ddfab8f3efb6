//! Gaps in sequence numbers.

/// Gaps that are remembered.
const GAPS: usize = 4;

/// Follows the sequence numbers of one topic.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct SeqWatch {
    /// The first number and the last.
    pub range: Option<(u64, u64)>,
    /// How many times numbers were left out.
    pub gaps: u64,
    /// How many numbers were left out in all.
    pub missing: u64,
    /// How many times a number was not above the one before: the publisher was restarted.
    pub restarts: u64,
    /// Numbers that were left out last, the first and the one behind, in no order: a message that comes behind its neighbours is of these.
    left_out: [Option<(u64, u64)>; GAPS],
}

impl SeqWatch {
    /// Takes note of the next message's number. What came before the first one seen is nobody's loss.
    pub fn saw(&mut self, seq: u64) {
        let (first, last) = self.range.unwrap_or((seq, seq));
        let is_of = |gap: &Option<(u64, u64)>| gap.is_some_and(|(from, to)| (from..to).contains(&seq));
        if let Some(gap) = self.left_out.iter().position(is_of) {
            return self.came_late(seq, gap);
        }
        if let Some(skipped) = seq.checked_sub(last).and_then(|step| step.checked_sub(2)) {
            self.gaps += 1;
            self.missing = self.missing.saturating_add(skipped.saturating_add(1));
            self.remember((last + 1, seq));
        } else if self.range.is_some() && seq <= last {
            self.restarts += 1;
            self.left_out = [None; GAPS];
        }
        self.range = Some((first, seq));
    }

    /// A number of this gap: it is not missing, and of the gap two are left, or one or none.
    fn came_late(&mut self, seq: u64, gap: usize) {
        let Some((from, to)) = self.left_out[gap].take() else {
            return;
        };
        self.missing = self.missing.saturating_sub(1);
        let rest = [(from, seq), (seq + 1, to)].into_iter().filter(|(from, to)| to > from);
        self.gaps = (self.gaps + rest.clone().count() as u64).saturating_sub(1);
        rest.for_each(|rest| self.remember(rest));
    }

    /// In a free place, or in that of the gap of the lowest numbers.
    fn remember(&mut self, gap: (u64, u64)) {
        let place = self.left_out.iter_mut().min();
        if let Some(place) = place {
            *place = Some(gap);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watched(seqs: &[u64]) -> SeqWatch {
        let mut watch = SeqWatch::default();
        seqs.iter().for_each(|&seq| watch.saw(seq));
        watch
    }

    #[test]
    fn gaps_are_counted_by_place_and_by_number() {
        let watch = watched(&[5, 6, 9, 10, 12]);
        assert_eq!((watch.gaps, watch.missing, watch.restarts), (2, 3, 0));
        assert_eq!(watch.range, Some((5, 12)));
    }

    /// Two neighbours that had changed places were a number that was missing, twice, and a publisher that was restarted.
    #[test]
    fn a_number_that_comes_behind_its_neighbours_is_not_missing() {
        let counts = |seqs: &[u64]| {
            let watch = watched(seqs);
            (watch.gaps, watch.missing, watch.restarts)
        };
        assert_eq!(counts(&[5, 7, 6, 8]), (0, 0, 0));
        assert_eq!(counts(&[5, 9, 7, 8, 10]), (1, 1, 0));
        assert_eq!(counts(&[5, 9, 7, 8, 6, 10]), (0, 0, 0));
        assert_eq!(counts(&[5, 9, 6, 7, 8, 10]), (0, 0, 0));
        // The same one again is of a publisher that began anew.
        assert_eq!(counts(&[5, 7, 6, 6, 7]), (0, 0, 1));
        assert_eq!(watched(&[5, 7, 6]).range, Some((5, 7)));
    }

    #[test]
    fn a_publisher_that_starts_anew_is_not_a_gap() {
        let watch = watched(&[7, 8, 0, 1, 1]);
        assert_eq!((watch.gaps, watch.missing, watch.restarts), (0, 0, 2));
    }

    #[test]
    fn extremes_do_not_overflow() {
        let watch = watched(&[0, u64::MAX, 0, u64::MAX]);
        assert_eq!((watch.gaps, watch.missing), (2, u64::MAX));
    }
}
