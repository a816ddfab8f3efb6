//! How long images take on the CPU and on a card, so that a card that is no help is not waited for.

use std::time::Duration;

use scene::Sampling;

/// The weight of a new image in the mean: a mean over some 16 images.
const NEW: f64 = 1.0 / 16.0;
/// A card is slower once it was so over this many images of a view.
const IMAGES: u32 = 64;
/// One image may take so much longer than on the CPU, and never less than [`LEAST`], as every machine stops for a while now and then.
const LENIENCE: u32 = 2;
const LEAST: Duration = Duration::from_millis(30);

/// The times of images, by their size and way of sampling.
#[derive(Debug)]
pub(super) struct Pace {
    times: Vec<Times>,
    least: Duration,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            times: Vec::new(),
            least: LEAST,
        }
    }
}

#[derive(Debug)]
struct Times {
    size: [u32; 2],
    sampling: Sampling,
    cpu_ns: Option<f64>,
    card_ns: f64,
    card_images: u32,
}

impl Pace {
    /// An image took this long on the CPU.
    pub(super) fn of_cpu(&mut self, size: [u32; 2], sampling: &Sampling, took_ns: i64) {
        let times = self.times(size, sampling);
        times.cpu_ns = Some(mean(times.cpu_ns, took_ns));
    }

    /// An image took this long on the card; in words, where the card is slower than the CPU.
    pub(super) fn of_card(&mut self, size: [u32; 2], sampling: &Sampling, took_ns: i64) -> Option<String> {
        let times = self.times(size, sampling);
        times.card_ns = mean((times.card_images > 0).then_some(times.card_ns), took_ns);
        times.card_images = times.card_images.saturating_add(1);
        let cpu_ns = times
            .cpu_ns
            .filter(|cpu_ns| times.card_images >= IMAGES && times.card_ns > *cpu_ns)?;
        Some(format!(
            "{:.1} ms an image, the CPU takes {:.1} ms",
            times.card_ns / 1e6,
            cpu_ns / 1e6
        ))
    }

    /// How long an image of the card is waited for; `None` where the CPU has drawn none of the kind.
    pub(super) fn patience(&mut self, size: [u32; 2], sampling: &Sampling) -> Option<Duration> {
        let cpu_ns = self.times(size, sampling).cpu_ns?;
        Some((Duration::from_nanos(cpu_ns as u64) * LENIENCE).max(self.least))
    }

    /// Waits for no image longer than twice the CPU's time: a card may be too fast to be late by [`LEAST`].
    #[cfg(test)]
    pub(super) fn be_strict(&mut self) {
        self.least = Duration::ZERO;
    }

    fn times(&mut self, size: [u32; 2], sampling: &Sampling) -> &mut Times {
        let known = self
            .times
            .iter()
            .position(|t| t.size == size && t.sampling == *sampling);
        let at = known.unwrap_or_else(|| {
            self.times.push(Times {
                size,
                sampling: *sampling,
                cpu_ns: None,
                card_ns: 0.0,
                card_images: 0,
            });
            self.times.len() - 1
        });
        &mut self.times[at]
    }
}

fn mean(before: Option<f64>, new_ns: i64) -> f64 {
    let new = new_ns as f64;
    before.map_or(new, |mean| mean + (new - mean) * NEW)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Filter;

    const SIZE: [u32; 2] = [512, 512];

    #[test]
    fn a_card_is_waited_for_twice_as_long_as_the_cpu_takes() {
        let (mut pace, sampling) = (Pace::default(), Sampling::from(Filter::Linear));
        assert_eq!(pace.patience(SIZE, &sampling), None);
        pace.of_cpu(SIZE, &sampling, 40_000_000);
        assert_eq!(pace.patience(SIZE, &sampling), Some(Duration::from_millis(80)));
        pace.of_cpu([8, 8], &sampling, 1000);
        assert_eq!(pace.patience([8, 8], &sampling), Some(LEAST));
        assert_eq!(pace.patience(SIZE, &Filter::Cubic.into()), None);
    }

    #[test]
    fn a_card_is_slow_when_it_is_so_on_the_whole() {
        let (mut pace, sampling) = (Pace::default(), Sampling::from(Filter::Linear));
        pace.of_cpu(SIZE, &sampling, 2_000_000);
        // Fast but for one image in a hundred.
        let late =
            (0..1000).filter_map(|i| pace.of_card(SIZE, &sampling, if i % 100 == 0 { 9_000_000 } else { 500_000 }));
        assert_eq!(late.count(), 0);
        let late = (0..64).find_map(|_| pace.of_card(SIZE, &sampling, 3_000_000)).unwrap();
        assert!(late.contains("the CPU takes 2.0 ms"), "{late}");
    }
}
