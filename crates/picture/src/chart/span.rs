//! The stretch of numbers that an axis shows, and where its ticks are.

use super::scale::Scale;

/// About as many ticks as an axis gets.
const TICKS: f64 = 8.0;
/// Decades that get ticks at 2 and 5 too.
const FEW_DECADES: f64 = 3.0;

/// What an axis shows, in lengths: numbers, or their decimal logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Span {
    /// For values that all have a place, or for a range that is given and has one.
    pub(crate) fn of((scale, range): (Scale, Option<[f64; 2]>), values: impl Iterator<Item = f64>) -> Self {
        let fixed = range.filter(|[low, high]| low < high && scale.places(*low) && scale.places(*high));
        if let Some([low, high]) = fixed.map(|ends| ends.map(|x| scale.place(x))) {
            return Self { scale, low, high };
        }
        let empty = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = values
            .map(|x| scale.place(x))
            .fold(empty, |[low, high], at| [low.min(at), high.max(at)]);
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        match scale {
            Scale::Linear => Self { scale, low, high }.rounded(),
            Scale::Log => {
                // Whole decades, at least one.
                let low = low.floor();
                let high = high.ceil().max(low + 1.0);
                Self { scale, low, high }
            }
        }
    }

    /// Widened to whole steps, and where it is a point, to something around it.
    fn rounded(self) -> Self {
        let around = (self.high.abs() * 0.1).max(self.low.abs() * 0.1).max(f64::MIN_POSITIVE);
        let point = self.high - self.low <= around * 1e-9;
        let wide = match (point, self.low == 0.0 && self.high == 0.0) {
            (false, _) => self,
            (true, true) => Self {
                low: -1.0,
                high: 1.0,
                ..self
            },
            (true, false) => Self {
                low: self.low - around,
                high: self.high + around,
                ..self
            },
        };
        let step = wide.step();
        Self {
            low: (wide.low / step).floor() * step,
            high: (wide.high / step).ceil() * step,
            ..wide
        }
    }

    /// The distance of linear ticks.
    fn step(&self) -> f64 {
        let rough = (self.high - self.low) / TICKS;
        let power = 10.0_f64.powf(rough.log10().floor()).max(f64::MIN_POSITIVE);
        let nice = [1.0, 2.0, 5.0].into_iter().find(|m| m * power >= rough * 0.999);
        nice.unwrap_or(10.0) * power
    }

    /// Where a number lies, from 0 (low) to 1 (high); `None` outside.
    pub(crate) fn fraction(&self, x: f64) -> Option<f64> {
        if !self.scale.places(x) {
            return None;
        }
        let at = self.part(self.scale.place(x));
        // Rounding may put an end just outside.
        (-1e-9..=1.0 + 1e-9).contains(&at).then_some(at)
    }

    /// The same for a length.
    pub(crate) fn part(&self, at: f64) -> f64 {
        (at - self.low) / (self.high - self.low)
    }

    /// Lowest and highest number.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.low, self.high].map(|at| self.value(at))
    }

    /// The number at a length.
    pub(crate) fn value(&self, at: f64) -> f64 {
        match self.scale {
            Scale::Linear => at,
            Scale::Log => 10.0_f64.powf(at),
        }
    }

    /// Lengths and labels of the ticks, ascending.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => self.linear_ticks(),
            Scale::Log => self.log_ticks(),
        }
    }

    fn linear_ticks(&self) -> Vec<(f64, String)> {
        let step = self.step();
        let first = (self.low / step - 1e-9).ceil();
        let count = ((self.high / step + 1e-9).floor() - first).clamp(0.0, 4.0 * TICKS) as u32;
        // Adding zero turns -0 into 0.
        let at = |i: u32| (first + f64::from(i)) * step + 0.0;
        (0..=count).map(|i| (at(i), linear_label(at(i), step))).collect()
    }

    fn log_ticks(&self) -> Vec<(f64, String)> {
        let decades = self.high - self.low;
        let every = (decades / TICKS).ceil().max(1.0);
        let digits: &[(f64, bool)] = if decades <= FEW_DECADES { &DIGITS } else { &DIGITS[..1] };
        let (first, last) = (self.low.floor(), self.high.ceil());
        let mut ticks = Vec::new();
        let mut decade = (first / every).floor() * every;
        while decade <= last {
            for (digit, named) in digits {
                let at = decade + digit.log10();
                let label = if *named {
                    self.log_label(*digit, decade)
                } else {
                    String::new()
                };
                if at >= self.low - 1e-9 && at <= self.high + 1e-9 {
                    ticks.push((at, label));
                }
            }
            decade += every;
        }
        ticks
    }

    /// Plain where every number of the axis is short.
    fn log_label(&self, digit: f64, decade: f64) -> String {
        if decade == 0.0 || (self.low >= 0.0 && self.high <= 5.0) {
            return format!("{:.0}", digit * 10.0_f64.powf(decade));
        }
        format!("{digit:.0}e{decade:.0}")
    }
}

/// Digits that get a tick, and whether it is named.
const DIGITS: [(f64, bool); 9] = [
    (1.0, true),
    (2.0, true),
    (3.0, false),
    (4.0, false),
    (5.0, true),
    (6.0, false),
    (7.0, false),
    (8.0, false),
    (9.0, false),
];

fn linear_label(value: f64, step: f64) -> String {
    if value != 0.0 && (value.abs() >= 1e6 || step < 1e-4) {
        return format!("{value:.2e}");
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 5.0) as usize;
    format!("{value:.decimals$}")
}
