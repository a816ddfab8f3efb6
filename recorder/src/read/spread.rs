//! The spread of a quantity, in little memory: percentiles of millions of values to half a percent.

use fit::Histogram;

/// Values of at least 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    histogram: Histogram,
    range: (u64, u64),
    sum: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self {
            histogram: Histogram::new(1.0, u64::MAX as f64),
            range: (u64::MAX, 0),
            sum: 0.0,
        }
    }
}

impl Spread {
    /// Takes note of a value.
    pub fn add(&mut self, value: u64) {
        self.histogram.add(value as f64);
        self.range = (self.range.0.min(value), self.range.1.max(value));
        self.sum += value as f64;
    }

    /// How many values there were.
    pub fn count(&self) -> u64 {
        self.histogram.count()
    }

    /// Their mean.
    pub fn mean(&self) -> Option<f64> {
        (self.count() > 0).then(|| self.sum / self.count() as f64)
    }

    /// The smallest and the largest.
    pub fn range(&self) -> Option<(u64, u64)> {
        (self.count() > 0).then_some(self.range)
    }

    /// The value below which the share `p` of them lies, 0 to 1: the smallest value with at least `p * count` at or below
    /// it, to 0.5 % of itself; exact at the ends.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let (least, most) = self.range()?;
        Some(self.histogram.quantile(p).clamp(least as f64, most as f64))
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
