//! Which poses a renderer draws where there is not time for all of them. Pure: numbers, ages and costs are handed in.
//!
//! One process draws each plane direction, and each passes poses over by itself when it falls behind. Were each to take whatever is the
//! newest, they would show different poses. So each takes the poses whose number is a multiple of its stride, 1, 2, 4 and so on: those of
//! a larger stride are among those of a smaller one, and whoever gathers images finds poses that all have.

/// Taken of the time from one pose that is drawn to the next: more is too much, and at half the stride this would be little.
const TOO_MUCH: f64 = 0.8;
const LITTLE: f64 = 0.6;
/// The stride grows once this share of the last few drawings, of which the newest counts so much, took too much.
const MOST_LATE: f64 = 0.4;
const NEWEST: f64 = 0.125;
/// And so much in what a drawing takes.
const LATELY: f64 = 0.5;
/// So many drawings that took little, more than took more, before it shrinks: two seconds of 60 poses.
const CALM: u32 = 120;
/// One that took more takes away so many of these.
const RESTLESS: u32 = 1;

/// The stride of one process, by its own recent cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Stride {
    log2: u32,
    /// The share of drawings that took too much.
    late: f64,
    calm: u32,
    /// What a drawing takes of late, ns.
    usual_ns: f64,
}

/// What a drawing was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drew {
    /// How long it took, ns.
    pub(crate) took_ns: i64,
    /// From one pose to the next, ns; 0 where that is not known.
    pub(crate) interval_ns: i64,
    /// Whether a pose that was to be drawn was passed over for it.
    pub(crate) behind: bool,
    /// The age beyond which no image is to be left standing for want of the rule, ns.
    pub(crate) oldest_ns: i64,
}

impl Stride {
    /// Every so many poses.
    pub(crate) fn every(&self) -> u64 {
        1 << self.log2
    }

    /// Whether a pose with this number is drawn.
    pub(crate) fn takes(&self, seq: u64) -> bool {
        seq.is_multiple_of(self.every())
    }

    /// Learns from a drawing.
    pub(crate) fn drew(&mut self, drew: Drew) {
        if drew.interval_ns <= 0 {
            return;
        }
        let most = largest(drew.interval_ns, drew.oldest_ns);
        self.log2 = self.log2.min(most);
        let part = |took_ns: f64, log2: u32| took_ns / ((1_u64 << log2) as f64 * drew.interval_ns as f64);
        let took_ns = drew.took_ns as f64;
        self.usual_ns += LATELY * (took_ns - self.usual_ns);
        let is_late = drew.behind || part(took_ns, self.log2) > TOO_MUCH;
        self.late += NEWEST * (f64::from(u8::from(is_late)) - self.late);
        self.calm = match !drew.behind && 2.0 * part(took_ns, self.log2) < LITTLE {
            true => self.calm + 1,
            false => self.calm.saturating_sub(RESTLESS),
        };
        if self.late > MOST_LATE && self.log2 < most {
            // At once as far as it must: each step would cost drawings that are too dear.
            let enough = (self.log2 + 1..most).find(|log2| part(self.usual_ns, *log2) <= TOO_MUCH);
            self.begin(enough.unwrap_or(most));
        } else if self.calm >= CALM {
            self.begin(self.log2.saturating_sub(1));
        }
    }

    fn begin(&mut self, log2: u32) {
        *self = Self {
            log2,
            usual_ns: self.usual_ns,
            ..Self::default()
        };
    }
}

/// The largest stride, as a power of 2, with which an image is replaced before its pose is older than `oldest_ns`, an interval for
/// drawing included.
fn largest(interval_ns: i64, oldest_ns: i64) -> u32 {
    // To the nearest whole number: captures of a steady source lie a little more or less than its interval apart.
    let intervals = (oldest_ns.saturating_add(interval_ns / 2) / interval_ns).saturating_sub(1);
    u32::try_from(intervals).ok().and_then(u32::checked_ilog2).unwrap_or(0)
}

/// Which of the poses that wait is drawn, by its place; `None`: none of them yet. `seqs` in the order in which they came.
///
/// The newest multiple of the stride. Where several wait, this process has fallen behind: the newest multiple of twice the stride then,
/// where there is one, as processes that fall behind by different times meet there.
pub(crate) fn choose(
    seqs: impl DoubleEndedIterator<Item = u64> + ExactSizeIterator + Clone,
    stride: Stride,
) -> Option<usize> {
    let mut taken = seqs.clone().filter(|seq| stride.takes(*seq));
    let is_behind = taken.next().is_some() && taken.next().is_some();
    let twice = 2 * stride.every();
    let of_twice = || seqs.clone().rposition(|seq| seq.is_multiple_of(twice));
    let newest = || seqs.clone().rposition(|seq| stride.takes(seq));
    match is_behind {
        true => of_twice().or_else(newest),
        false => newest(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const INTERVAL: i64 = 16_666_667;
    const OLDEST: i64 = 50_000_000;

    fn drew(part: f64, behind: bool, oldest_ns: i64) -> Drew {
        Drew {
            took_ns: (part * INTERVAL as f64) as i64,
            interval_ns: INTERVAL,
            behind,
            oldest_ns,
        }
    }

    fn of(log2: u32) -> Stride {
        Stride {
            log2,
            ..Stride::default()
        }
    }

    proptest! {
        /// What a slower process draws, a faster one draws too.
        #[test]
        fn larger_strides_nest_in_smaller_ones(seq: u64, a in 0_u32..10, b in 0_u32..10) {
            let (small, large) = (of(a.min(b)), of(a.max(b)));
            prop_assert!(!large.takes(seq) || small.takes(seq));
            prop_assert!(of(0).takes(seq));
            // Among any so many numbers in a row there is one.
            prop_assert!((0..large.every()).any(|k| large.takes(seq.wrapping_add(k))));
        }

        #[test]
        fn a_cost_that_stays_the_same_leads_to_a_stride_that_stays(part in 0.01..20.0_f64, start in 0_u32..4, most in 1_i64..40) {
            let mut stride = of(start);
            let oldest_ns = most * INTERVAL;
            let mut step = |n| (0..n).map(|_| { stride.drew(drew(part, false, oldest_ns)); stride.every() }).collect::<Vec<_>>();
            step(2000);
            let every = step(2000);
            prop_assert!(every.iter().all(|found| *found == every[0]), "{part}: {every:?}");
            // Time enough, or as far as images may age.
            let limit = 1_u64 << largest(INTERVAL, oldest_ns);
            prop_assert!(part <= TOO_MUCH * every[0] as f64 || every[0] == limit, "{part}: {}", every[0]);
            prop_assert!(every[0] <= limit);
            if part < 0.5 * LITTLE {
                prop_assert_eq!(every[0], 1);
            }
        }

        /// Restarted, jumping, repeated: whatever numbers come, one of them is chosen where one is taken, and no other.
        #[test]
        fn what_is_chosen_is_one_that_is_taken(seqs in prop::collection::vec(prop_oneof![0..9_u64, any::<u64>()], 0..16), log2 in 0_u32..5) {
            let stride = of(log2);
            match choose(seqs.iter().copied(), stride) {
                Some(place) => prop_assert!(stride.takes(seqs[place])),
                None => prop_assert!(!seqs.iter().any(|seq| stride.takes(*seq))),
            }
        }

        /// Two processes that look at the same stream at times of their own, and whose windows have a multiple of twice the larger
        /// stride in common and nothing newer that is one, draw that.
        #[test]
        fn those_that_fall_behind_meet(first in 0_u64..1000, lengths in prop::array::uniform2(1_u64..8), log2 in 0_u32..3) {
            let every = of(log2).every();
            let meeting = (first + 1).next_multiple_of(2 * every);
            // Both begin at least a stride before it, and end before the next.
            let windows = lengths.map(|length| meeting.saturating_sub(every)..=meeting + length.min(2 * every - 1));
            for window in windows {
                let seqs: Vec<u64> = window.collect();
                let chosen = choose(seqs.iter().copied(), of(log2)).map(|place| seqs[place]);
                prop_assert_eq!(chosen, Some(meeting));
            }
        }
    }

    #[test]
    fn falling_behind_lets_it_grow_at_once_and_calm_lets_it_shrink_late() {
        let mut stride = Stride::default();
        (0..4).for_each(|_| stride.drew(drew(0.3, true, OLDEST)));
        assert_eq!(stride.every(), 2);
        (0..1000).for_each(|_| stride.drew(drew(3.0, true, OLDEST)));
        // Three intervals, one of them for drawing: more than two between images would let one grow too old.
        assert_eq!(stride.every(), 2);
        (0..CALM - 1).for_each(|_| stride.drew(drew(0.2, false, OLDEST)));
        let before = stride.every();
        (0..40).for_each(|_| stride.drew(drew(0.2, false, OLDEST)));
        assert_eq!((before, stride.every()), (2, 1));
    }

    #[test]
    fn what_is_far_too_dear_is_drawn_seldom_after_four_drawings() {
        let mut stride = Stride::default();
        // Fifteen intervals each, where images may age for a hundred: sixteen intervals and their reserve are enough.
        (0..4).for_each(|_| stride.drew(drew(15.0, false, 100 * INTERVAL)));
        assert_eq!(stride.every(), 32);
    }

    #[test]
    fn without_a_known_interval_nothing_is_learnt() {
        let mut stride = Stride::default();
        for interval_ns in [0, -1, i64::MIN] {
            stride.drew(Drew {
                interval_ns,
                ..drew(9.0, true, OLDEST)
            });
        }
        assert_eq!(stride, Stride::default());
        assert_eq!(
            [largest(1, i64::MAX), largest(INTERVAL, 0), largest(INTERVAL, i64::MIN)],
            [0, 0, 0]
        );
        assert_eq!(
            [
                largest(INTERVAL, OLDEST),
                largest(INTERVAL, 200_000_000),
                largest(1_000_000, OLDEST)
            ],
            [1, 3, 5]
        );
    }
}
