//! A number over time: its spread, and its course with every peak and every gap.

use fit::Histogram;
use serde::Serialize;

use super::columns::{Cell, Columns};

/// A number that is 0 or more, over time.
#[derive(Debug, Clone)]
pub(super) struct Quantity {
    histogram: Histogram,
    range: Option<(f64, f64)>,
    unknown: u64,
    /// Grows where the course is broken.
    run: u64,
    pub(super) columns: Columns<Column>,
}

/// What falls into one column.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Column {
    /// `None`: no number.
    pub(super) drawn: Option<Drawn>,
    /// Samples whose number is not known.
    pub(super) unknown: u64,
}

/// The numbers of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Drawn {
    /// The least and the largest.
    pub(super) range: (f64, f64),
    /// Which unbroken runs its first and its last number belong to.
    pub(super) runs: (u64, u64),
}

impl Cell for Column {
    fn take(&mut self, later: Self) {
        self.unknown += later.unknown;
        self.drawn = match (self.drawn, later.drawn) {
            (Some(a), Some(b)) => Some(Drawn {
                range: (a.range.0.min(b.range.0), a.range.1.max(b.range.1)),
                runs: (a.runs.0, b.runs.1),
            }),
            (a, b) => a.or(b),
        };
    }
}

/// How the numbers are spread. Least and largest are exact, the others within 0.5 % by nearest rank.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Spread {
    /// How many there are.
    pub(super) count: u64,
    /// The least.
    pub(super) min: f64,
    /// Half of them are at most this.
    pub(super) p50: f64,
    /// 95 of a hundred.
    pub(super) p95: f64,
    /// 99 of a hundred.
    pub(super) p99: f64,
    /// The largest.
    pub(super) max: f64,
}

impl Quantity {
    /// Numbers from `least` to `most` are told apart.
    pub(super) fn new(least: f64, most: f64) -> Self {
        Self {
            histogram: Histogram::new(least, most),
            range: None,
            unknown: 0,
            run: 0,
            columns: Columns::default(),
        }
    }

    /// A number; what is none counts as not known.
    pub(super) fn add(&mut self, t_ns: i64, number: f64) {
        if !(number.is_finite() && number >= 0.0) {
            return self.unknown(t_ns);
        }
        self.histogram.add(number);
        let (least, most) = self.range.unwrap_or((number, number));
        self.range = Some((least.min(number), most.max(number)));
        self.columns.at(t_ns).take(Column {
            drawn: Some(Drawn {
                range: (number, number),
                runs: (self.run, self.run),
            }),
            unknown: 0,
        });
    }

    /// A sample whose number is not known: a gap, and never a zero.
    pub(super) fn unknown(&mut self, t_ns: i64) {
        self.unknown += 1;
        self.columns.at(t_ns).unknown += 1;
        self.broken();
    }

    /// Nothing leads from the number before to the next one.
    pub(super) fn broken(&mut self) {
        self.run += 1;
    }

    /// How many numbers are not known.
    pub(super) fn unknowns(&self) -> u64 {
        self.unknown
    }

    /// How they are spread; `None` without any.
    pub(super) fn spread(&self) -> Option<Spread> {
        let (min, max) = self.range?;
        let quantile = |share| self.histogram.quantile(share).clamp(min, max);
        Some(Spread {
            count: self.histogram.count(),
            min,
            p50: quantile(0.5),
            p95: quantile(0.95),
            p99: quantile(0.99),
            max,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_the_largest_and_the_gaps_stay() {
        let mut quantity = Quantity::new(1e-3, 1e3);
        // An hour at 100 Hz, a single peak, a single dip, and one sample of which nothing is known.
        for i in 0..360_000_i64 {
            let t_ns = i * 10_000_000;
            match i {
                123_456 => quantity.add(t_ns, 90.0),
                222_222 => quantity.add(t_ns, 0.0),
                300_000 => quantity.unknown(t_ns),
                _ => quantity.add(t_ns, 1.0),
            }
        }
        let spread = quantity.spread().unwrap();
        assert_eq!((spread.min, spread.max, spread.count), (0.0, 90.0, 359_999));
        assert!((spread.p50 - 1.0).abs() < 0.005, "{spread:?}");
        let drawn = || quantity.columns.each().filter_map(|(_, column)| column.drawn);
        assert_eq!(drawn().filter(|d| d.range.1 == 90.0).count(), 1);
        assert_eq!(drawn().filter(|d| d.range.0 == 0.0).count(), 1);
        assert_eq!(drawn().filter(|d| d.runs.0 != d.runs.1).count(), 1);
        assert_eq!(quantity.columns.each().map(|(_, c)| c.unknown).sum::<u64>(), 1);
    }

    #[test]
    fn what_is_no_number_is_not_known() {
        let mut quantity = Quantity::new(1e-3, 1e3);
        for odd in [f64::NAN, f64::INFINITY, -1.0] {
            quantity.add(0, odd);
        }
        assert_eq!((quantity.unknowns(), quantity.spread()), (3, None));
    }
}
