//! Gaps in sequence numbers.

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
}

impl SeqWatch {
    /// Takes note of the next message's number. What came before the first one seen is nobody's loss.
    pub fn saw(&mut self, seq: u64) {
        let (first, last) = self.range.unwrap_or((seq, seq));
        if let Some(skipped) = seq.checked_sub(last).and_then(|step| step.checked_sub(2)) {
            self.gaps += 1;
            self.missing = self.missing.saturating_add(skipped.saturating_add(1));
        } else if self.range.is_some() && seq <= last {
            self.restarts += 1;
        }
        self.range = Some((first, seq));
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
