//! Whether a localizer still measures: one that has hung up sends the same numbers under fresh stamps. Asked of what it saw,
//! before a pose is made of it, as smoothing and a reference that moves would hide it.

/// Different measurements that are kept. A peer that gives each in several kinds of message, as a matrix and as a quaternion, rounds it
/// otherwise in each: one that has hung up sends as many in turn. A marker at rest has noise, and gives a new one within a few frames.
const KEPT: usize = 8;

/// What was measured of one marker last, and since when nothing else was.
#[derive(Debug, Clone, Default)]
pub(super) struct Standing {
    /// The newest different measurements, at most [`KEPT`], the newest last.
    kept: Vec<Vec<u64>>,
    since_ns: i64,
}

/// The longest that the tool or the reference stands, ns: one that has hung up is none beside one that moves. `places` are the numbers
/// measured of each at `t_capture_ns`.
pub(super) fn longest_ns<I>(standing: &mut [Standing; 2], places: [I; 2], t_capture_ns: i64) -> i64
where
    I: Iterator<Item = f64> + Clone,
{
    let each = standing.iter_mut().zip(places);
    each.map(|(standing, numbers)| standing.stands_ns(numbers, t_capture_ns))
        .fold(0, i64::max)
}

impl Standing {
    /// For how long nothing new has come, ns, with those `numbers` captured at `t_capture_ns`; 0 where there are none.
    fn stands_ns(&mut self, numbers: impl Iterator<Item = f64> + Clone, t_capture_ns: i64) -> i64 {
        let bits = numbers.map(f64::to_bits);
        // A marker that is hidden and comes back with the same numbers was not measured in between.
        if bits.clone().next().is_none() {
            return 0;
        }
        if self.kept.iter().any(|kept| bits.clone().eq(kept.iter().copied())) {
            return t_capture_ns.saturating_sub(self.since_ns);
        }
        // The room of the oldest is used again: there is nothing to allocate for each frame.
        let mut newest = if self.kept.len() < KEPT {
            Vec::new()
        } else {
            self.kept.remove(0)
        };
        newest.clear();
        newest.extend(bits);
        self.kept.push(newest);
        self.since_ns = t_capture_ns;
        0
    }

    /// What comes is no neighbour of what was.
    pub(super) fn forget(&mut self) {
        self.kept.clear();
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

    /// Stated: LIVE for ever, as each number differed from the one before. True: the peer had hung up, and sent its last pose as a
    /// matrix and as a quaternion, 1e-7 apart, in turn, or one kind of message at times only.
    #[test]
    fn a_measurement_in_several_kinds_of_message_stands() {
        for kinds in [2, KEPT as i64] {
            for seldom in [1, 15] {
                let mut standing = Standing::default();
                let mut longest_ns = 0;
                for k in 0..400 {
                    let kind = if k % seldom == 0 { k / seldom % kinds } else { 0 };
                    let numbers = [0.9, 0.1 + 1e-7 * kind as f64, -1500.0];
                    longest_ns = standing.stands_ns(numbers.into_iter(), k);
                }
                // Each kind was new once.
                assert_eq!(longest_ns, 399 - (kinds - 1) * seldom, "{kinds} kinds, each {seldom}");
            }
        }
    }

    /// Stated: tracking. True: the marker on the patient had hung up, in two kinds of message, beside a tool that moved.
    #[test]
    fn one_that_has_hung_up_stands_beside_one_that_moves() {
        for hung in [0, 1] {
            let mut both = [Standing::default(), Standing::default()];
            let mut longest = Vec::new();
            for k in 0..20 {
                let mut places = [k as f64; 2];
                places[hung] = 1e-7 * (k % 2) as f64;
                longest.push(longest_ns(&mut both, places.map(std::iter::once), k));
            }
            let expected: Vec<i64> = [0].into_iter().chain(0..19).collect();
            assert_eq!(longest, expected);
        }
    }

    /// A localizer of 1e-3 mm, whose noise at rest is a step or two: its numbers come again, and something new does too.
    #[test]
    fn a_marker_at_rest_in_coarse_steps_is_measured() {
        let mut standing = Standing::default();
        let mut random = 1_u32;
        let mut step = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            1e-3 * f64::from((random >> 16) % 3)
        };
        let stood = (0..10_000).map(|k| {
            let place = [step(), step(), -1500.0 + step()];
            standing.stands_ns(place.into_iter(), k)
        });
        // 30 frames at 60 Hz are the default of `limits.frozen_ms`; one of 27 places is new with 2/3 at least.
        assert!(stood.fold(0, i64::max) < 30);
    }
}
