//! Whether a localizer still measures: one that has hung up sends the same numbers under fresh stamps. Asked of what it saw,
//! before a pose is made of it, as smoothing and a reference that moves would hide it.

/// What was measured of one marker last, and since when it has been the same.
#[derive(Debug, Clone, Default)]
pub(super) struct Standing {
    numbers: Vec<u64>,
    since_ns: i64,
}

impl Standing {
    /// For how long the same `numbers` have come, ns, with those captured at `t_capture_ns`; 0 where there are none.
    pub(super) fn stands_ns(&mut self, numbers: impl Iterator<Item = f64> + Clone, t_capture_ns: i64) -> i64 {
        let bits = numbers.map(f64::to_bits);
        let same = !self.numbers.is_empty() && bits.clone().eq(self.numbers.iter().copied());
        if same {
            return t_capture_ns.saturating_sub(self.since_ns);
        }
        // A marker that is hidden and comes back with the same numbers was not measured in between.
        if bits.clone().next().is_some() {
            self.numbers.clear();
            self.numbers.extend(bits);
            self.since_ns = t_capture_ns;
        }
        0
    }

    /// What comes is no neighbour of what was.
    pub(super) fn forget(&mut self) {
        self.numbers.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_very_same_numbers_stand() {
        let mut standing = Standing::default();
        let mut at = |numbers: &[f64], ns| standing.stands_ns(numbers.iter().copied(), ns);
        assert_eq!(at(&[1.0, 2.0], 0), 0);
        assert_eq!(at(&[1.0, 2.0], 10), 10);
        assert_eq!(at(&[], 20), 0);
        assert_eq!(at(&[1.0, 2.0], 30), 30);
        assert_eq!(at(&[1.0, 2.0 + f64::EPSILON * 2.0], 40), 0);
        assert_eq!(at(&[1.0], 50), 0);
        assert_eq!(at(&[1.0], 70), 20);
        standing.forget();
        assert_eq!(standing.stands_ns([1.0].into_iter(), 90), 0);
    }
}
