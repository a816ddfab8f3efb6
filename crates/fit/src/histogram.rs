//! Counts of positive numbers in logarithmic bins: quantiles to half a percent in bounded memory, however many there are.

/// Each bin is 1 % wider than the one before: the logarithm of 1.01. So the middle of a bin is within 0.5 % of all in it.
const WIDTH: f64 = 0.009_950_330_853_168_083;

/// Counts by size.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    least: f64,
    counts: Vec<u64>,
    count: u64,
    most: f64,
}

impl Histogram {
    /// For numbers from `least` to `most`; the first bin holds all below (negative ones and NaN too), the last all above.
    pub fn new(least: f64, most: f64) -> Self {
        // One bin more at either end, for what lies beyond the range.
        let bins = ((most / least).ln() / WIDTH).ceil() as usize + 2;
        Self {
            least,
            counts: vec![0; bins],
            count: 0,
            most: 0.0,
        }
    }

    /// One more.
    pub fn add(&mut self, number: f64) {
        // The cast saturates: NaN, which the logarithm of a negative number is too, and what is below 0 become bin 0.
        let place = ((number / self.least).ln() / WIDTH + 1.0).floor() as usize;
        let last = self.counts.len() - 1;
        self.counts[place.min(last)] += 1;
        self.count += 1;
        // This maximum passes over NaN.
        self.most = self.most.max(number);
    }

    /// How many there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The largest, exactly; 0 without any.
    pub fn most(&self) -> f64 {
        self.most
    }

    /// The number that `share` (0 to 1) of them do not exceed, by nearest rank: the middle of its bin, within 0.5 %, and 0 for the
    /// first bin and without any. Exact for the largest, which also stands for all others beyond the range.
    pub fn quantile(&self, share: f64) -> f64 {
        // Nearest rank; 1 at least, so that a share of 0 is the least number.
        let rank = (share * self.count as f64).ceil().max(1.0) as u64;
        if rank >= self.count {
            return self.most;
        }
        let mut seen = 0;
        let within = |&(_, count): &(usize, &u64)| {
            seen += *count;
            seen >= rank
        };
        let bin = self.counts.iter().enumerate().find(within).map_or(0, |(bin, _)| bin);
        let middle = match bin {
            0 => 0.0,
            // Bin k holds least exp(WIDTH (k - 1)) to least exp(WIDTH k); this is its geometric middle.
            _ => self.least * (WIDTH * (bin as f64 - 0.5)).exp(),
        };
        // What lies beyond the last bin is known by the largest only.
        if bin == self.counts.len() - 1 {
            self.most
        } else {
            middle.min(self.most)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_numbers_to_half_a_percent() {
        let mut histogram = Histogram::new(1e-3, 1e6);
        let numbers: Vec<f64> = (1..=100_000).map(|i| f64::from(i) * 0.013).collect();
        // In an order that is not theirs.
        for i in 0..numbers.len() {
            histogram.add(numbers[(i * 7919) % numbers.len()]);
        }
        for share in [0.001, 0.01, 0.5, 0.95, 0.99, 0.9999, 1.0] {
            let truth = numbers[(share * numbers.len() as f64).ceil() as usize - 1];
            let found = histogram.quantile(share);
            assert!((found / truth - 1.0).abs() < 0.005, "{share}: {found} {truth}");
        }
        assert_eq!((histogram.count(), histogram.most()), (100_000, 1300.0));
    }

    #[test]
    fn odd_numbers_have_a_bin_too() {
        let empty = Histogram::new(1e-3, 1e6);
        assert_eq!((empty.quantile(0.5), empty.most()), (0.0, 0.0));
        for (odd, found) in [(0.0, 0.0), (-5.0, 0.0), (f64::NAN, 0.0), (1e12, 1e12)] {
            let mut histogram = Histogram::new(1e-3, 1e6);
            histogram.add(odd);
            assert_eq!(histogram.quantile(0.99), found, "{odd}");
        }
    }
}
