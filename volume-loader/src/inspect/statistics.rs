//! The HU of a volume: how often each of the 65536 is there.

use serde::Serialize;

use super::Histogram;

/// The HU of air, and of what scanners clip to it. A padding below is one that nothing measured can have.
const LOWEST_AIR_HU: i16 = -1024;
/// The parts of the voxels below a percentile, per cent.
const PARTS: [f64; 7] = [1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0];

/// The padding where it can be told from air.
pub(super) fn distinct_padding(padding_hu: i16) -> Option<i16> {
    (padding_hu < LOWEST_AIR_HU).then_some(padding_hu)
}

/// The HU of what was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HuRange {
    /// The smallest.
    pub min: i16,
    /// The largest.
    pub max: i16,
    /// The arithmetic mean.
    pub mean: f64,
    /// Pairs of per cent and HU: the smallest HU that so many of the voxels do not exceed.
    pub percentiles: Vec<(f64, i16)>,
}

/// What was not measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Padding {
    /// The HU in its place.
    pub hu: i16,
    /// Whether it can be told from air. Only then is it left out of every other number.
    pub told_from_air: bool,
    /// How many voxels hold it.
    pub voxels: u64,
    /// The same as a part of all, 0 to 1.
    pub share: f64,
}

/// How many voxels hold each HU, from -32768 on.
#[derive(Debug, Clone)]
pub(super) struct Counts(Vec<u64>);

impl Default for Counts {
    fn default() -> Self {
        Self(vec![0; 1 << 16])
    }
}

impl Counts {
    pub(super) fn add(&mut self, slice: &[i16]) {
        for &hu in slice {
            if let Some(count) = self.0.get_mut(place(hu)) {
                *count += 1;
            }
        }
    }

    /// HU and how many voxels hold it, ascending, where any do; without a padding that can be told from air.
    fn measured(&self, padding_hu: i16) -> impl Iterator<Item = (i16, u64)> {
        let left_out = distinct_padding(padding_hu);
        let counted = (i16::MIN..=i16::MAX).zip(self.0.iter().copied());
        counted.filter(move |&(hu, count)| count > 0 && Some(hu) != left_out)
    }

    pub(super) fn range(&self, padding_hu: i16) -> Option<HuRange> {
        let (min, _) = self.measured(padding_hu).next()?;
        let (max, _) = self.measured(padding_hu).last()?;
        let total: u64 = self.measured(padding_hu).map(|(_, count)| count).sum();
        // Exact: at most 2^32 voxels of 2^15.
        let sum: i64 = self
            .measured(padding_hu)
            .map(|(hu, count)| i64::from(hu) * count as i64)
            .sum();
        let percentile = |part: f64| {
            let needed = (part / 100.0 * total as f64).ceil() as u64;
            let mut below = 0;
            let reached = self.measured(padding_hu).find(|&(_, count)| {
                below += count;
                below >= needed
            });
            (part, reached.map_or(max, |(hu, _)| hu))
        };
        Some(HuRange {
            min,
            max,
            mean: sum as f64 / total as f64,
            percentiles: PARTS.map(percentile).to_vec(),
        })
    }

    pub(super) fn padding(&self, padding_hu: i16) -> Padding {
        let voxels = self.0.get(place(padding_hu)).copied().unwrap_or_default();
        let all: u64 = self.0.iter().sum();
        Padding {
            hu: padding_hu,
            told_from_air: distinct_padding(padding_hu).is_some(),
            voxels,
            share: voxels as f64 / all.max(1) as f64,
        }
    }

    pub(super) fn histogram(&self, padding_hu: i16) -> Histogram {
        Histogram::of(self.measured(padding_hu))
    }
}

fn place(hu: i16) -> usize {
    // -32768 is the first.
    (i32::from(hu) - i32::from(i16::MIN)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_can_be_counted_by_hand() {
        let mut counts = Counts::default();
        counts.add(&[-2000, -2000, -1000, 0, 40, 40, 1000, 32767]);
        counts.add(&[i16::MIN]);
        let padding = counts.padding(-2000);
        assert_eq!((padding.voxels, padding.told_from_air), (2, true));
        assert!((padding.share - 2.0 / 9.0).abs() < 1e-15);
        let range = counts.range(-2000).unwrap();
        assert_eq!((range.min, range.max), (i16::MIN, i16::MAX));
        assert!((range.mean - (-32768.0 - 1000.0 + 80.0 + 1000.0 + 32767.0) / 7.0).abs() < 1e-12);
        assert_eq!(range.percentiles[3], (50.0, 40));
        // Of seven the first is 14 %, the second 29 %.
        assert_eq!((range.percentiles[1].1, range.percentiles[2].1), (i16::MIN, -1000));
        assert_eq!(
            counts.range(-1000).unwrap().mean,
            (-32768.0 - 4000.0 - 1000.0 + 80.0 + 1000.0 + 32767.0) / 9.0
        );
    }

    #[test]
    fn nothing_but_padding_has_no_range() {
        let mut counts = Counts::default();
        counts.add(&[-3024; 10]);
        assert_eq!(counts.range(-3024), None);
        assert_eq!(counts.padding(-3024).share, 1.0);
        assert!(!counts.padding(-1024).told_from_air);
    }
}
