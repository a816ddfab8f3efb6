//! How late frames come after their capture, over a window.

/// Counts of the last slices of a window, by lateness.
///
/// Lateness is counted in classes of a quarter of an octave from 1 us to 268 s: a quantile is right to 19 %.
#[derive(Debug, Clone)]
pub(super) struct Lateness {
    slices: [[u32; CLASSES]; SLICES],
    /// The slice that is being filled, and when it began.
    now: usize,
    began_ns: Option<i64>,
    slice_ns: i64,
}

/// How late the frames of a window came: arrival less mapped time, nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Spread {
    /// Half of the frames came less late.
    pub p50_ns: i64,
    /// 99 frames of 100 came less late.
    pub p99_ns: i64,
    /// Frames that were counted: mapped ones only.
    pub frames: u64,
}

const SLICES: usize = 10;
/// Four an octave, 28 octaves above [`LEAST_NS`].
const CLASSES: usize = 4 * 28;
/// The upper end of the first class.
const LEAST_NS: f64 = 1000.0;

impl Lateness {
    pub(super) fn new(window_ns: i64) -> Self {
        let slice_ns = (window_ns / SLICES as i64).max(1);
        Self {
            slices: [[0; CLASSES]; SLICES],
            now: 0,
            began_ns: None,
            slice_ns,
        }
    }

    /// Counts one frame.
    pub(super) fn count(&mut self, arrival_ns: i64, late_ns: i64) {
        self.turn(arrival_ns);
        let count = &mut self.slices[self.now][class(late_ns)];
        *count = count.saturating_add(1);
    }

    /// Empties the slices that are older than the window.
    fn turn(&mut self, arrival_ns: i64) {
        let began = *self.began_ns.get_or_insert(arrival_ns);
        let gone = arrival_ns.saturating_sub(began) / self.slice_ns;
        for _ in 0..gone.clamp(0, SLICES as i64) {
            self.now = (self.now + 1) % SLICES;
            self.slices[self.now] = [0; CLASSES];
        }
        if gone > 0 {
            self.began_ns = Some(began.saturating_add(gone.saturating_mul(self.slice_ns)));
        }
    }

    pub(super) fn spread(&self) -> Spread {
        let sums: [u64; CLASSES] = std::array::from_fn(|k| self.slices.iter().map(|slice| u64::from(slice[k])).sum());
        let frames: u64 = sums.iter().sum();
        let quantile = |per_cent: u64| {
            let wanted = (frames * per_cent).div_ceil(100);
            let below = sums.iter().scan(0, |sum, count| {
                *sum += count;
                Some(*sum)
            });
            let class = below.take_while(|sum| *sum < wanted).count();
            if frames == 0 { 0 } else { upper_end_ns(class) }
        };
        Spread {
            p50_ns: quantile(50),
            p99_ns: quantile(99),
            frames,
        }
    }
}

fn class(late_ns: i64) -> usize {
    let octaves = (late_ns as f64 / LEAST_NS).max(1.0).log2();
    ((4.0 * octaves).ceil() as usize).min(CLASSES - 1)
}

fn upper_end_ns(class: usize) -> i64 {
    (LEAST_NS * (class as f64 / 4.0).exp2()).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_a_class() {
        let mut lateness = Lateness::new(20_000_000_000);
        (1..=1000).for_each(|k| lateness.count(k * 10_000_000, k * 10_000));
        let Spread { p50_ns, p99_ns, frames } = lateness.spread();
        assert_eq!(frames, 1000);
        for (found, wanted) in [(p50_ns, 5.0e6), (p99_ns, 9.9e6)] {
            assert!((1.0..=1.19).contains(&(found as f64 / wanted)), "{found} {wanted}");
        }
    }

    #[test]
    fn what_is_older_than_the_window_is_forgotten() {
        let mut lateness = Lateness::new(20_000_000_000);
        lateness.count(0, 1_000_000_000);
        lateness.count(25_000_000_000, 1000);
        assert_eq!(
            lateness.spread(),
            Spread {
                p50_ns: 1000,
                p99_ns: 1000,
                frames: 1
            }
        );
        lateness.count(i64::MAX, i64::MAX);
        lateness.count(i64::MIN, i64::MIN);
        assert_eq!(lateness.spread().frames, 2);
    }

    #[test]
    fn nothing_has_no_spread() {
        assert_eq!(Lateness::new(0).spread(), Spread::default());
    }
}
