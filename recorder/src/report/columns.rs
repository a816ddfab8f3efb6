//! Something over time in bounded memory, however long it goes on: columns that grow twice as wide where there would be too many.
//!
//! Nothing is sampled: each column takes in all that falls into it, so that no peak and no short moment is lost.

use std::collections::BTreeMap;

/// At most so many columns lie between the first and the last.
pub(super) const MOST: i64 = 1024;
/// The narrowest columns are 2^20 ns wide, a thousandth of a second.
const NARROWEST: u32 = 20;

/// What a column holds.
pub(super) trait Cell: Default {
    /// Takes in the neighbour that lies behind it.
    fn take(&mut self, later: Self);
}

/// Columns of 2^n ns each. Times are ns, of a size below 2^61.
#[derive(Debug, Clone)]
pub(super) struct Columns<T> {
    shift: u32,
    span_ns: Option<(i64, i64)>,
    cells: BTreeMap<i64, T>,
}

impl<T> Default for Columns<T> {
    fn default() -> Self {
        Self {
            shift: NARROWEST,
            span_ns: None,
            cells: BTreeMap::new(),
        }
    }
}

impl<T: Cell> Columns<T> {
    /// The column of this time.
    pub(super) fn at(&mut self, t_ns: i64) -> &mut T {
        self.hold(t_ns);
        self.cells.entry(t_ns >> self.shift).or_default()
    }

    /// Calls `add` with each column of a stretch, and how many ns of it lie in that column.
    pub(super) fn along(&mut self, from_ns: i64, to_ns: i64, mut add: impl FnMut(&mut T, u64)) {
        if to_ns <= from_ns {
            return;
        }
        self.hold(from_ns);
        self.hold(to_ns - 1);
        let mut at_ns = from_ns;
        while at_ns < to_ns {
            let key = at_ns >> self.shift;
            let end_ns = ((key + 1) << self.shift).min(to_ns);
            add(self.cells.entry(key).or_default(), (end_ns - at_ns).unsigned_abs());
            at_ns = end_ns;
        }
    }

    /// From when to when each column goes, ns, and what it holds, in order.
    pub(super) fn each(&self) -> impl Iterator<Item = ((i64, i64), &T)> {
        let shift = self.shift;
        let times = move |key: i64| (key << shift, (key + 1) << shift);
        self.cells.iter().map(move |(&key, cell)| (times(key), cell))
    }

    /// Makes the columns wide enough for this time to be in one of them.
    fn hold(&mut self, t_ns: i64) {
        let (first, last) = self
            .span_ns
            .map_or((t_ns, t_ns), |(first, last)| (first.min(t_ns), last.max(t_ns)));
        self.span_ns = Some((first, last));
        let mut wider = 0;
        while (last >> (self.shift + wider)) - (first >> (self.shift + wider)) >= MOST {
            wider += 1;
        }
        if wider == 0 {
            return;
        }
        self.shift += wider;
        for (key, cell) in std::mem::take(&mut self.cells) {
            self.cells.entry(key >> wider).or_default().take(cell);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// How many, and the largest.
    #[derive(Default)]
    struct Peak(u64, i64);

    impl Cell for Peak {
        fn take(&mut self, later: Self) {
            *self = Self(self.0 + later.0, self.1.max(later.1));
        }
    }

    proptest! {
        #[test]
        fn nothing_is_lost_and_there_are_never_too_many(
            times in prop::collection::vec(prop_oneof![0..2_000_000_000_i64, -5_i64..(1 << 60)], 1..3000)
        ) {
            let mut columns = Columns::<Peak>::default();
            for &t in &times {
                let cell = columns.at(t);
                *cell = Peak(cell.0 + 1, cell.1.max(t));
            }
            prop_assert!(columns.each().count() as i64 <= MOST);
            prop_assert_eq!(columns.each().map(|(_, cell)| cell.0).sum::<u64>(), times.len() as u64);
            for ((from, to), cell) in columns.each() {
                let largest = times.iter().copied().filter(|t| (from..to).contains(t)).max().unwrap();
                prop_assert_eq!(cell.1, largest.max(0));
            }
        }

        #[test]
        fn stretches_add_up(mut bounds in prop::collection::vec(0..(1_i64 << 60), 2..50)) {
            bounds.sort_unstable();
            let mut columns = Columns::<Peak>::default();
            for pair in bounds.windows(2) {
                columns.along(pair[0], pair[1], |cell, ns| cell.0 += ns);
            }
            let total: u64 = columns.each().map(|(_, cell)| cell.0).sum();
            prop_assert_eq!(total, (bounds[bounds.len() - 1] - bounds[0]).unsigned_abs());
        }
    }
}
