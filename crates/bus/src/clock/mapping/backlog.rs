//! How long frames may have waited on the peer's side, where its clock seems to have been set back.
//!
//! Arrivals alone cannot tell a clock that was set back by 3 s from a queue that grew by 3 s. The stamps can, in part: a queue hands frames on
//! in their order, so that no stamp of it goes back. What the law rises by more than stamps went back before, at once or little by little, may be
//! a queue's, and is kept until the law falls.

/// Less than this is not stated: what a law moves by on a busy link, ns. It is summed up all the same.
const LEAST_NS: i64 = 3_000_000;
/// A clock that was set is found at most so long after the stamp that went back, ns: [`super::trial`] takes 4 s.
const REMEMBERED_NS: i64 = 6_000_000_000;
/// What went back is remembered by pieces of so long, ns.
const PIECE_NS: i64 = 500_000_000;
const PIECES: usize = (REMEMBERED_NS / PIECE_NS) as usize;
/// A stamp that went back by itself is made up for so soon, ns.
const MADE_UP_NS: i64 = 500_000_000;
/// No source of poses is slower, ns.
const LONGEST_NS: i64 = 200_000_000;
/// The weight of one more interval, one of so many.
const WEIGHT: i64 = 8;

#[derive(Debug, Clone, Default)]
pub(super) struct Backlog {
    /// Stamp and arrival of the frame before.
    last: Option<(i64, i64)>,
    /// The usual interval of stamps.
    interval_ns: i64,
    /// By how much stamps went back lately, less by how much they jumped forward.
    went_back: Credit,
    /// Arrival of the last frame whose stamp went back.
    back_at_ns: Option<i64>,
    /// By how much stamps left out what may yet come, and the arrival of the last that did.
    skipped: Option<(i64, i64)>,
    /// By how much the law fell, not long ago, and when.
    fell: Option<(i64, i64)>,
    /// How high the law lies above its lowest, but for what stamps show.
    sum_ns: i64,
}

impl Backlog {
    /// Frames may have waited for so long from the beginning on.
    pub(super) fn of(waited_ns: i64) -> Self {
        Self {
            sum_ns: waited_ns.max(0),
            ..Self::default()
        }
    }

    /// Another connection was made. A stamp that goes back from one to the next shows no clock that was set: the peer may hand on what it kept.
    pub(super) fn reconnected(&mut self) {
        *self = Self {
            interval_ns: self.interval_ns,
            sum_ns: self.sum_ns,
            ..Self::default()
        };
    }

    /// A frame came, whether or not it is mapped.
    pub(super) fn see(&mut self, device_ns: i64, arrival_ns: i64) {
        let Some((device_before, arrival_before)) = self.last.replace((device_ns, arrival_ns)) else {
            return;
        };
        let by_stamps = device_ns.saturating_sub(device_before);
        let by_arrivals = arrival_ns.saturating_sub(arrival_before).max(0);
        let usual_ns = self.interval_ns;
        self.settle_fall(by_stamps, arrival_ns);
        if by_stamps < 0 {
            self.back_at_ns = Some(arrival_ns);
            let back_ns = usual_ns.saturating_sub(by_stamps);
            // A frame that was left out comes after those behind it: no clock was set.
            let skipped_ns = self.skipped_before(arrival_ns);
            self.skipped = None;
            return self
                .went_back
                .add(arrival_ns, back_ns.saturating_sub(skipped_ns).max(0));
        }
        let jump_ns = by_stamps.saturating_sub(usual_ns);
        if usual_ns == 0 || jump_ns <= usual_ns / 2 {
            // A pause is no interval.
            self.interval_ns = match usual_ns {
                0 => by_stamps.min(LONGEST_NS),
                _ => usual_ns + (by_stamps.min(2 * usual_ns) - usual_ns) / WEIGHT,
            };
        } else if by_stamps.saturating_sub(by_arrivals) > usual_ns / 2 {
            // A stamp that is ahead of its clock is followed by one that goes back: that is no clock that was set.
            self.went_back.add(arrival_ns, jump_ns.saturating_neg());
        } else if self.is_soon_after_back(arrival_ns) {
            // A frame is missing, or the stamp that went back is made up for and the frame waited as long: then no clock was set.
            let made_up_ns = self.went_back.sum(arrival_ns).clamp(0, jump_ns);
            self.went_back.add(arrival_ns, made_up_ns.saturating_neg());
            self.skip(arrival_ns, jump_ns - made_up_ns);
        } else {
            self.skip(arrival_ns, jump_ns);
        }
    }

    /// What the law fell by was seen as a jump of the stamps too: that takes nothing from what they go back by later. Unless they do at once, as
    /// behind a frame that came before those of its time.
    fn settle_fall(&mut self, by_stamps: i64, arrival_ns: i64) {
        let Some((by_ns, at_ns)) = self.fell else {
            return;
        };
        let is_over = arrival_ns.saturating_sub(at_ns) > MADE_UP_NS;
        if is_over {
            let jumped_ns = self.went_back.sum(arrival_ns).min(0).max(by_ns);
            self.went_back.add(arrival_ns, jumped_ns.saturating_neg());
        }
        if is_over || by_stamps < 0 {
            self.fell = None;
        }
    }

    fn skip(&mut self, arrival_ns: i64, by_ns: i64) {
        self.skipped = Some((self.skipped_before(arrival_ns).saturating_add(by_ns), arrival_ns));
    }

    fn skipped_before(&self, arrival_ns: i64) -> i64 {
        let recent = self
            .skipped
            .filter(|(_, at_ns)| arrival_ns.saturating_sub(*at_ns) <= MADE_UP_NS);
        recent.map_or(0, |(by_ns, _)| by_ns)
    }

    fn is_soon_after_back(&self, arrival_ns: i64) -> bool {
        self.back_at_ns
            .is_some_and(|at_ns| arrival_ns.saturating_sub(at_ns) <= MADE_UP_NS)
    }

    /// The law rose by so much: its clock was set back, or all frames wait longer. It fell where that is negative.
    pub(super) fn rises(&mut self, by_ns: i64) {
        let now_ns = self.last.map_or(0, |(_, arrival_ns)| arrival_ns);
        let went_back_ns = self.went_back.sum(now_ns);
        if by_ns <= 0 {
            let before_ns = self.fell.map_or(0, |(by_ns, _)| by_ns);
            self.fell = (by_ns < 0)
                .then(|| (before_ns.saturating_add(by_ns), now_ns))
                .or(self.fell);
            self.sum_ns = self.sum_ns.saturating_add(by_ns).max(0);
            return;
        }
        let rest_ns = self.hidden(by_ns);
        self.went_back
            .add(now_ns, went_back_ns.clamp(0, by_ns).saturating_neg());
        self.sum_ns = self.sum_ns.saturating_add(rest_ns);
    }

    /// How much of so much that the law rose by no stamp shows that went back. What lay between two frames whose stamps go back is known to one
    /// interval, and hardly better the law that begins with the second.
    fn hidden(&self, late_ns: i64) -> i64 {
        let now_ns = self.last.map_or(0, |(_, arrival_ns)| arrival_ns);
        let shown_ns = self.went_back.sum(now_ns).clamp(0, late_ns.max(0));
        let rest_ns = late_ns.saturating_sub(shown_ns).max(0);
        let slack_ns = self.interval_ns.min(shown_ns);
        if rest_ns > slack_ns { rest_ns } else { 0 }
    }

    /// How long frames may have waited beside what the law says, ns.
    pub(super) fn ns(&self) -> i64 {
        if self.sum_ns < LEAST_NS { 0 } else { self.sum_ns }
    }
}

/// A sum of which each part is forgotten [`REMEMBERED_NS`] after it came, by pieces of [`PIECE_NS`].
#[derive(Debug, Clone, Default)]
struct Credit {
    /// The number of a piece of time, and what came in it.
    pieces: [(i64, i64); PIECES],
}

impl Credit {
    /// What is of the other sign is made up for at once, the oldest first: it would be forgotten before what stands against it.
    fn add(&mut self, at_ns: i64, by_ns: i64) {
        let number = at_ns.div_euclid(PIECE_NS);
        let mut rest_ns = by_ns;
        let oldest = Self::place(number) + 1;
        self.pieces.rotate_left(oldest);
        for (_, kept_ns) in self.pieces.iter_mut().filter(|(of, _)| is_new(*of, number)) {
            if kept_ns.signum() == -rest_ns.signum() {
                let both_ns = kept_ns.saturating_abs().min(rest_ns.saturating_abs());
                *kept_ns += rest_ns.signum() * both_ns;
                rest_ns -= rest_ns.signum() * both_ns;
            }
        }
        self.pieces.rotate_right(oldest);
        // Always there: the remainder is less than their number.
        if let Some(piece) = self.pieces.get_mut(Self::place(number)) {
            let before_ns = if piece.0 == number { piece.1 } else { 0 };
            *piece = (number, before_ns.saturating_add(rest_ns));
        }
    }

    fn place(number: i64) -> usize {
        number.rem_euclid(PIECES as i64) as usize
    }

    fn sum(&self, now_ns: i64) -> i64 {
        let now = now_ns.div_euclid(PIECE_NS);
        let new = self.pieces.iter().filter(|(number, _)| is_new(*number, now));
        new.fold(0, |sum: i64, (_, by_ns)| sum.saturating_add(*by_ns))
    }
}

/// Whether what came in a piece of time is remembered in another.
fn is_new(number: i64, now: i64) -> bool {
    (0..PIECES as i64).contains(&now.saturating_sub(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    /// 50 Hz for a second.
    fn steady() -> Backlog {
        let mut backlog = Backlog::default();
        (0..50).for_each(|k| backlog.see(k * 20 * MS, k * 20 * MS));
        backlog
    }

    #[test]
    fn steps_that_no_stamp_shows_add_up_until_the_clock_steps_forward() {
        let mut backlog = steady();
        for by_ms in [2, 72, 225, 229] {
            backlog.rises(by_ms * MS);
        }
        assert_eq!(backlog.ns(), 528 * MS);
        backlog.rises(-500 * MS);
        assert_eq!(backlog.ns(), 28 * MS);
        backlog.rises(i64::MIN);
        assert_eq!(backlog.ns(), 0);
        backlog.rises(i64::MAX);
        backlog.rises(i64::MAX);
        assert_eq!(backlog.ns(), i64::MAX);
    }

    #[test]
    fn a_step_that_a_stamp_shows_is_a_clock_that_was_set_but_not_one_behind_a_stamp_that_was_ahead_or_long_ago() {
        let mut set = steady();
        set.see(1000 * MS - 3000 * MS, 1000 * MS);
        let mut more = set.clone();
        let [mut late, mut rest] = [set.clone(), set.clone()];
        set.rises(3010 * MS);
        assert_eq!(set.ns(), 0);
        // What stamps went back by counts once.
        set.rises(500 * MS);
        assert_eq!(set.ns(), 500 * MS);
        // What is left of it hides no more than itself once more.
        rest.rises(2995 * MS);
        rest.rises(24 * MS);
        assert_eq!(rest.ns(), 19 * MS);
        more.rises(3200 * MS);
        assert_eq!(more.ns(), 200 * MS);
        late.see(4100 * MS, 7100 * MS);
        late.rises(3000 * MS);
        assert_eq!(late.ns(), 3000 * MS);
        let mut stray = steady();
        stray.see(1000 * MS + 3000 * MS, 1000 * MS);
        stray.see(1020 * MS, 1020 * MS);
        stray.rises(3000 * MS);
        assert!(stray.ns() > 2900 * MS, "{}", stray.ns());
    }
}
