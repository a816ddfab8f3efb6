//! The spread of a quantity, in little memory: percentiles of millions of values to half a percent.

/// Bins a factor of 1.01 wide.
const PER_E: f64 = 100.498_756_211_208_9;
/// Up to the largest number of 64 bits.
const BINS: usize = 4460;

/// Values of at least 0, counted in bins whose limits grow by 1 %.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    bins: Vec<u64>,
    count: u64,
    range: (u64, u64),
    sum: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self {
            bins: Vec::new(),
            count: 0,
            range: (u64::MAX, 0),
            sum: 0.0,
        }
    }
}

impl Spread {
    /// Takes note of a value.
    pub fn add(&mut self, value: u64) {
        if self.bins.is_empty() {
            self.bins = vec![0; BINS];
        }
        // Below BINS: the logarithm of the largest value times 100.5 is 4459.
        let bin = ((value.max(1) as f64).ln() * PER_E) as usize;
        self.bins[bin.min(BINS - 1)] += 1;
        self.count += 1;
        self.range = (self.range.0.min(value), self.range.1.max(value));
        self.sum += value as f64;
    }

    /// How many values there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// The smallest and the largest.
    pub fn range(&self) -> Option<(u64, u64)> {
        (self.count > 0).then_some(self.range)
    }

    /// The value below which the share `p` of them lies, 0 to 1: the smallest value with at least `p * count` at or below
    /// it, to 0.5 % of itself; exact at the ends.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let (least, most) = self.range()?;
        let wanted = (p * self.count as f64).ceil().clamp(1.0, self.count as f64) as u64;
        if wanted == self.count {
            return Some(most as f64);
        }
        let mut below = 0;
        let bin = self.bins.iter().position(|n| {
            below += n;
            below >= wanted
        })?;
        let middle = ((bin as f64 + 0.5) / PER_E).exp();
        Some(middle.clamp(least as f64, most as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn quantiles_are_within_half_a_percent(
            mut values in prop::collection::vec(prop_oneof![0..50_u64, any::<u64>(), 1_000_000..2_000_000_u64], 1..200),
            p in 0.0..=1.0_f64,
        ) {
            let mut spread = Spread::default();
            values.iter().for_each(|&value| spread.add(value));
            values.sort_unstable();
            let wanted = ((p * values.len() as f64).ceil() as usize).clamp(1, values.len());
            let exact = values[wanted - 1] as f64;
            let found = spread.quantile(p).unwrap();
            // Half a bin, and the rounding of the logarithm.
            prop_assert!((found - exact).abs() <= 0.005 * exact.max(1.0) + 1.0, "{} {}", found, exact);
            prop_assert_eq!(spread.quantile(1.0), Some(values[values.len() - 1] as f64));
            prop_assert_eq!(spread.range(), Some((values[0], values[values.len() - 1])));
        }
    }

    #[test]
    fn nothing_has_no_quantiles() {
        assert_eq!(
            (Spread::default().quantile(0.5), Spread::default().mean()),
            (None, None)
        );
    }
}
