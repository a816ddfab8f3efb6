//! Whether images keep to the clock of the poses, by how late they come.
//!
//! Of an image that bears a stamp of the poses' clock one number is known: how much later it arrived than a pose of that stamp would have at the
//! earliest. That is the time the scanner took, the way of its many bytes, and, where the stamps are of *another* clock, the offset of
//! the two. From outside those are one sum. So three things are asked of it:
//!
//! * It is never below 0 ([`bus::clock::mapping::Mapping::capture_of`]) and never above what the scene allows (`latest_ms`).
//! * Its least over two seconds stays what it was when images began, within [`STEP_NS`] and what the poses' law is uncertain by. A clock that is
//!   set, or goes faster than the other, is found out so. Single images may be late: a network is.
//! * An offset that is constant and below `latest_ms` is **not** seen. That images and poses share a clock is the scene's word.

use std::collections::VecDeque;

use bus::clock;

/// The least lateness may differ by this from what it was, ns: at 10 mm/s, as a probe glides, a place is off by 0.2 mm then.
pub(crate) const STEP_NS: i64 = 20_000_000;
/// Over so long, and so many images, the least is taken: of nine, whatever their delays scatter by, one is near the least.
const WINDOW_NS: i64 = 2_000_000_000;
const FEWEST: u32 = 9;
/// Images of this time are kept as one, ns.
const BIN_NS: i64 = 250_000_000;

/// Why an image's time is its arrival.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Untimed {
    /// The scene wants it so.
    #[error("the scene says clock = \"arrival\"")]
    Wanted,
    /// Nobody vouches for the law.
    #[error("poses have no time of their own, or none came for 1 s")]
    NoPoses,
    /// The law of the poses is less certain than what images are held to.
    #[error("the poses' clock is known to {} ms alone", STEP_NS / 1_000_000)]
    Vague,
    /// No stamp, or one from the future.
    #[error("stamps are missing or later than their arrival: not of the poses' clock")]
    OtherClock,
    /// Later than the scene allows.
    #[error("more than {} ms (localizer.images.latest_ms) later than poses of their stamp: another clock, or an old picture", clock::ms(*latest_ns))]
    Late {
        /// What it allows, ns.
        latest_ns: i64,
    },
    /// How late images are is not known yet.
    #[error("they just began")]
    JustBegun,
    /// The clock of the stamps was set, or goes otherwise than that of the poses.
    #[error("their clock does not keep to that of the poses")]
    Stepped,
}

/// The lateness of the images of one peer.
#[derive(Debug, Clone)]
pub(crate) struct ImageLaw {
    latest_ns: i64,
    bins: VecDeque<Bin>,
    /// What the least lateness was when the last window began to be believed, ns.
    base_ns: Option<i64>,
    is_settled: bool,
}

/// The images of a quarter of a second.
#[derive(Debug, Clone, Copy)]
struct Bin {
    from_ns: i64,
    least_ns: i64,
    count: u32,
}

impl ImageLaw {
    /// Of images that come up to `latest_ns` later than the poses of their time.
    pub(crate) fn new(latest_ns: i64) -> Self {
        Self {
            latest_ns,
            bins: VecDeque::new(),
            base_ns: None,
            is_settled: false,
        }
    }

    /// Another connection: its images have to show that they are as late as those before were.
    pub(crate) fn reconnected(&mut self) {
        self.bins.clear();
        self.is_settled = false;
    }

    /// Judges an image that arrived `late_ns` after its time by the poses' law, which is known to `uncertain_ns`. Gives, once it is known,
    /// by how much the clock of the images was set against that of the poses since they began, ns.
    pub(crate) fn judge(
        &mut self,
        late_ns: i64,
        uncertain_ns: i64,
        arrival_ns: i64,
    ) -> (Result<(), Untimed>, Option<i64>) {
        if uncertain_ns > STEP_NS {
            return (Err(Untimed::Vague), None);
        }
        let latest_ns = self.latest_ns;
        if late_ns > latest_ns {
            return (Err(Untimed::Late { latest_ns }), None);
        }
        let allowed_ns = STEP_NS + uncertain_ns;
        // It arrived before it could have.
        if self.is_settled && self.base_ns.is_some_and(|base_ns| base_ns - late_ns > allowed_ns) {
            self.reconnected();
        }
        self.push(late_ns, arrival_ns);
        let Some(least_ns) = self.least_ns(arrival_ns) else {
            let is_first = self.base_ns.is_none();
            return (Err(if is_first { Untimed::JustBegun } else { Untimed::Stepped }), None);
        };
        let by_ns = *self.base_ns.get_or_insert(least_ns) - least_ns;
        let is_other = by_ns.abs() > allowed_ns;
        if is_other && self.is_settled {
            // Some of this window may be of before: the next one says by how much.
            self.reconnected();
            self.push(late_ns, arrival_ns);
            return (Err(Untimed::Stepped), None);
        }
        self.is_settled = true;
        if is_other {
            self.base_ns = Some(least_ns);
        }
        (Ok(()), is_other.then_some(by_ns))
    }

    fn push(&mut self, late_ns: i64, arrival_ns: i64) {
        match self.bins.back_mut() {
            Some(bin) if arrival_ns.saturating_sub(bin.from_ns) < BIN_NS => {
                bin.least_ns = bin.least_ns.min(late_ns);
                bin.count = bin.count.saturating_add(1);
            }
            _ => self.bins.push_back(Bin {
                from_ns: arrival_ns,
                least_ns: late_ns,
                count: 1,
            }),
        }
    }

    /// The least of the window, and what is older is let go of; `None` where it is not full.
    fn least_ns(&mut self, arrival_ns: i64) -> Option<i64> {
        let from_ns = arrival_ns.saturating_sub(WINDOW_NS);
        let mut count = self.bins.iter().fold(0_u32, |sum, bin| sum.saturating_add(bin.count));
        while let (Some(first), Some(second)) = (self.bins.front(), self.bins.get(1)) {
            let without = count.saturating_sub(first.count);
            if without < FEWEST || second.from_ns > from_ns {
                break;
            }
            count = without;
            self.bins.pop_front();
        }
        let is_full = count >= FEWEST && self.bins.front().is_some_and(|bin| bin.from_ns <= from_ns);
        let least = self.bins.iter().map(|bin| bin.least_ns).min();
        least.filter(|_| is_full)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Arrivals, ns, and what was said of each image.
    type Said = Vec<(i64, Result<(), Untimed>)>;

    const MS: i64 = 1_000_000;
    /// 25 a second.
    const EVERY_NS: i64 = 40 * MS;

    /// Images that arrive 60 ms after their time and up to 50 ms later, whose clock is set by `by_ms` (an image each `every_ns`) at `at_s`:
    /// what was said of each, with its arrival, and the steps.
    fn set(by_ms: i64, at_s: i64, to_s: i64, every_ns: i64) -> (Said, Vec<i64>) {
        let (mut law, mut said, mut steps) = (ImageLaw::new(300 * MS), Vec::new(), Vec::new());
        for i in 0..to_s * 1_000 * MS / every_ns {
            let arrival_ns = i * every_ns;
            let set_ns = if arrival_ns >= at_s * 1_000 * MS { by_ms * MS } else { 0 };
            let late_ns = 60 * MS + i * 7919 % 50 * MS - set_ns;
            let (result, step) = law.judge(late_ns, MS / 10, arrival_ns);
            said.push((arrival_ns, result));
            steps.extend(step);
        }
        (said, steps)
    }

    #[test]
    fn a_clock_of_images_that_is_set_either_way_is_found_and_told_once_with_its_size() {
        for by_ms in [-150, -60, -25, 25, 45] {
            let (said, steps) = set(by_ms, 10, 20, EVERY_NS);
            let (before, after) = said.split_at(250);
            assert!(
                before.iter().all(|(t, result)| result.is_ok() == (*t >= 2_000 * MS)),
                "{by_ms}"
            );
            let found = after.iter().position(|(_, result)| *result == Err(Untimed::Stepped));
            // Nothing that is found is found later than after a window, and nothing is believed before another one is over.
            assert!(
                found.is_some_and(|at| at as i64 * EVERY_NS <= 2_300 * MS),
                "{by_ms}: {found:?}"
            );
            let silent = after.iter().filter(|(_, result)| result.is_err()).count() as i64 * EVERY_NS;
            assert!((2_000 * MS..=2_300 * MS).contains(&silent), "{by_ms}: {silent}");
            assert!(
                matches!(steps[..], [by_ns] if (by_ns - by_ms * MS).abs() <= 5 * MS),
                "{by_ms}: {steps:?}"
            );
        }
    }

    #[test]
    fn what_is_less_than_the_bound_is_not_told_and_does_not_add_up() {
        for by_ms in [-18, 15] {
            let (said, steps) = set(by_ms, 10, 20, EVERY_NS);
            assert!(
                steps.is_empty() && said[50..].iter().all(|(_, result)| result.is_ok()),
                "{by_ms}"
            );
        }
        // A clock that goes 0.1 % otherwise: 1 ms a second, no step of which is seen.
        let (mut law, mut first, mut steps) = (ImageLaw::new(300 * MS), None, 0);
        for i in 0..1500 {
            let (result, step) = law.judge(60 * MS + i * EVERY_NS / 1000, 0, i * EVERY_NS);
            first = first.or((result == Err(Untimed::Stepped)).then_some(i * EVERY_NS));
            steps += usize::from(step.is_some());
        }
        assert!(
            first.is_some_and(|t| (20_000 * MS..24_000 * MS).contains(&t)),
            "{first:?}"
        );
        assert_eq!(steps, 2);
    }

    #[test]
    fn slow_images_are_held_to_nine_of_them() {
        let (said, steps) = set(-100, 30, 60, 500 * MS);
        assert_eq!(said.iter().position(|(_, result)| result.is_ok()), Some(8));
        let found = said.iter().rposition(|(_, result)| *result == Err(Untimed::Stepped));
        assert!(found.is_some_and(|at| at <= 60 + 9 + 9), "{found:?}");
        assert!(
            matches!(steps[..], [by_ns] if (by_ns + 100 * MS).abs() <= 12 * MS),
            "{steps:?}"
        );
    }

    /// A second clock that was 400 ms off gave images a time that looked like the poses'.
    #[test]
    fn images_later_than_the_scene_allows_are_none_of_the_clock() {
        let latest_ns = 300 * MS;
        let (mut law, late) = (ImageLaw::new(latest_ns), Err(Untimed::Late { latest_ns }));
        for i in 0..100 {
            assert_eq!(law.judge(latest_ns + 1, 0, i * EVERY_NS), (late, None));
        }
        let all: Vec<_> = (100..200).map(|i| law.judge(latest_ns, 0, i * EVERY_NS).0).collect();
        assert_eq!(all.iter().position(Result::is_ok), Some(50));
        // One that a network held up is none, and changes nothing.
        assert_eq!(law.judge(latest_ns + 1, 0, 200 * EVERY_NS).0, late);
        assert_eq!(law.judge(latest_ns, 0, 201 * EVERY_NS), (Ok(()), None));
        assert_eq!(law.judge(latest_ns, STEP_NS + 1, 202 * EVERY_NS).0, Err(Untimed::Vague));
    }

    #[test]
    fn a_delay_of_single_images_or_of_a_second_is_no_step() {
        let mut law = ImageLaw::new(300 * MS);
        for i in 0..1000 {
            // A busy link, for 1.5 s of each 10.
            let late_ns = if i % 250 > 212 { 200 * MS } else { 60 * MS };
            let (result, step) = law.judge(late_ns, 0, i * EVERY_NS);
            assert_eq!((result.is_ok(), step), (i >= 50, None), "{i}");
        }
    }

    /// A scanner that came back with another offset had the time of the one before.
    #[test]
    fn another_connection_is_compared_with_the_one_before() {
        for (by_ms, expected) in [(0, None), (-80, Some(-80 * MS))] {
            let mut law = ImageLaw::new(300 * MS);
            (0..100).for_each(|i| {
                let _ = law.judge(60 * MS, 0, i * EVERY_NS);
            });
            law.reconnected();
            let steps: Vec<i64> = (200..300)
                .filter_map(|i| law.judge((60 - by_ms) * MS, 0, i * EVERY_NS).1)
                .collect();
            assert_eq!(steps.first().copied(), expected);
        }
    }

    #[test]
    fn any_numbers_are_taken() {
        let mut law = ImageLaw::new(i64::MAX);
        for (late_ns, arrival_ns) in [(0, i64::MIN), (i64::MAX, i64::MAX), (0, 0), (0, i64::MIN)] {
            (0..20).for_each(|_| {
                let _ = law.judge(late_ns, STEP_NS, arrival_ns);
            });
        }
    }
}
