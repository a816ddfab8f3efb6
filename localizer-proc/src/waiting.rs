//! When people are told that frames may have waited: not with every frame, where some have and others have not.

/// It is over where no frame waited for so long, ns.
const QUIET_NS: i64 = 2_000_000_000;

/// What was told.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Waiting {
    /// For how long frames may have waited, as it was told last, ns; 0 for nothing told.
    told_ns: i64,
    /// When the last one came that had.
    last_ns: i64,
}

/// What is to be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Told {
    /// Frames may have waited for longer by half than was told.
    Longer,
    /// None has, for a while.
    Over,
}

impl Waiting {
    /// A frame came at `now_ns` that may have waited for `waited_ns`, 0 for none that is worth a word.
    pub(crate) fn of(&mut self, waited_ns: i64, now_ns: i64) -> Option<Told> {
        if waited_ns > 0 {
            self.last_ns = now_ns;
            let is_longer = waited_ns / 3 * 2 > self.told_ns;
            self.told_ns = if is_longer { waited_ns } else { self.told_ns };
            return is_longer.then_some(Told::Longer);
        }
        let is_over = self.told_ns > 0 && now_ns.saturating_sub(self.last_ns) >= QUIET_NS;
        self.told_ns = if is_over { 0 } else { self.told_ns };
        is_over.then_some(Told::Over)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of before between those of the present: two lines for each of them were told.
    #[test]
    fn what_comes_and_goes_is_told_once() {
        let mut waiting = Waiting::default();
        let ms = 1_000_000;
        let news: Vec<_> = (0..600)
            .filter_map(|k| waiting.of(if k < 400 && k % 2 == 0 { 400 * ms } else { 0 }, k * 16 * ms))
            .collect();
        assert_eq!(news, [Told::Longer, Told::Over]);
        assert_eq!(waiting.of(400 * ms, 10_000 * ms), Some(Told::Longer));
        assert_eq!(waiting.of(500 * ms, 10_010 * ms), None);
        assert_eq!(waiting.of(700 * ms, 10_020 * ms), Some(Told::Longer));
    }
}
