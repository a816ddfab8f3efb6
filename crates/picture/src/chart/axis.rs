//! Axes: what they show and how.

use super::scale::Scale;
use super::span::Span;

/// An axis of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// The quantity and its unit, for instance `time, ns`.
    pub title: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Lowest and highest number shown; `None`: whatever the points need.
    pub range: Option<[f64; 2]>,
}

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// The number, in the axis' unit.
    pub value: f64,
    /// The number in words; empty for a mark between two named ones.
    pub label: String,
}

impl Axis {
    /// A linear axis.
    pub fn linear(title: impl Into<String>) -> Self {
        Self::new(title.into(), Scale::Linear)
    }

    /// A logarithmic axis.
    pub fn log(title: impl Into<String>) -> Self {
        Self::new(title.into(), Scale::Log)
    }

    fn new(title: String, scale: Scale) -> Self {
        let range = None;
        Self { title, scale, range }
    }

    /// The same axis from `low` to `high`. A range that is empty or has no place on the scale is as if not given.
    pub fn within(self, low: f64, high: f64) -> Self {
        let range = Some([low, high]);
        Self { range, ..self }
    }

    /// Lowest and highest number shown for `values`, and the ticks between them, ascending.
    ///
    /// Linear ticks are 1, 2 or 5 times a power of ten apart. Logarithmic ones are powers of ten, with named ones at 2
    /// and 5 and unnamed ones between where there are at most three decades. Values that have no place are ignored.
    pub fn ticks(&self, values: impl IntoIterator<Item = f64>) -> ([f64; 2], Vec<Tick>) {
        let span = Span::of(
            (self.scale, self.range),
            values.into_iter().filter(|x| self.scale.places(*x)),
        );
        let ends = span.ends();
        let tick = |(at, label)| Tick {
            value: span.value(at),
            label,
        };
        (ends, span.ticks().into_iter().map(tick).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, values: &[f64]) -> Vec<String> {
        let (_, ticks) = axis.ticks(values.iter().copied());
        ticks.into_iter().map(|t| t.label).filter(|l| !l.is_empty()).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_hold_the_values() {
        let axis = Axis::linear("x");
        let (ends, ticks) = axis.ticks([-0.3, 1.04]);
        assert!(ends[0] <= -0.3 && ends[1] >= 1.04, "{ends:?}");
        assert!(
            ticks.windows(2).all(|w| (w[1].value - w[0].value - 0.2).abs() < 1e-12),
            "{ticks:?}"
        );
        assert_eq!(labels(&axis, &[0.0, 10.0]), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(&axis.within(0.0, 1.5e7), &[])[1], "2.00e6");
    }

    #[test]
    fn log_ticks_are_decades() {
        let axis = Axis::log("x");
        assert_eq!(
            labels(&axis, &[20.0, 900.0]),
            ["10", "20", "50", "100", "200", "500", "1000"]
        );
        assert_eq!(
            labels(&axis, &[1e-4, 2.0]),
            ["1e-4", "1e-3", "1e-2", "1e-1", "1", "1e1"]
        );
        let wide = labels(&axis, &[1e-17, 1e13]);
        assert!(wide.len() <= 9 && wide.contains(&"1e-16".to_owned()), "{wide:?}");
    }

    #[test]
    fn ranges_without_width_are_widened() {
        for value in [0.0, 3.0, -1e-12, 1e300, -1e300, 5e-324] {
            let ([low, high], ticks) = Axis::linear("x").ticks([value, value]);
            assert!(low <= value && value <= high && low < high, "{value}: {low} to {high}");
            assert!((2..50).contains(&ticks.len()), "{value}: {ticks:?}");
        }
        for value in [1.0, 3.0, 1e-300, 1e300] {
            let ([low, high], ticks) = Axis::log("x").ticks([value]);
            assert!(
                low <= value * 1.000_001 && value <= high * 1.000_001,
                "{value}: {low} to {high}"
            );
            assert!(ticks.len() >= 2, "{value}: {ticks:?}");
        }
        // Values that have no place, and none at all.
        assert_eq!(Axis::log("x").ticks([-1.0, 0.0, f64::NAN]).0, [1.0, 10.0]);
        assert_eq!(Axis::linear("x").ticks([f64::INFINITY]).0, [0.0, 1.0]);
    }

    #[test]
    fn a_fixed_range_is_kept_where_it_is_one() {
        let axis = |low, high| Axis::linear("x").within(low, high).ticks([5.0, 6.0]).0;
        assert_eq!(axis(-1.5, 2.25), [-1.5, 2.25]);
        assert_eq!(axis(2.0, 2.0), axis(f64::NAN, 1.0));
        assert_eq!(Axis::log("x").within(0.0, 10.0).ticks([2.0]).0, [1.0, 10.0]);
    }
}
