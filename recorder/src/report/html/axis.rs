//! Where a value is drawn, and which values are written beside an axis.

use super::units::whole;

/// The width of a drawing; on paper 4 units are a millimetre.
pub(super) const WIDTH: f64 = 720.0;
/// Where the plotted part begins and ends, from the left.
pub(super) const LEFT: f64 = 150.0;
pub(super) const RIGHT: f64 = 710.0;
/// The most words beside an axis of time: they never touch.
const MOST_TIMES: i64 = 8;

/// The axis of time: from when to when, ns.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeAxis {
    pub(super) from_ns: i64,
    pub(super) to_ns: i64,
}

impl TimeAxis {
    /// Units from the left; what is outside is drawn at the edge.
    pub(super) fn x(&self, t_ns: i64) -> f64 {
        let length = (self.to_ns - self.from_ns).max(1) as f64;
        let share = (t_ns.saturating_sub(self.from_ns) as f64 / length).clamp(0.0, 1.0);
        LEFT + share * (RIGHT - LEFT)
    }

    /// Moments that are written beside it, with their words.
    pub(super) fn ticks(&self) -> Vec<(i64, String)> {
        const MS: i64 = 1_000_000;
        const S: i64 = 1000 * MS;
        let steps = [
            100 * MS,
            200 * MS,
            500 * MS,
            S,
            2 * S,
            5 * S,
            10 * S,
            15 * S,
            30 * S,
            60 * S,
            120 * S,
            300 * S,
        ];
        let long = [
            600 * S,
            900 * S,
            1800 * S,
            3600 * S,
            7200 * S,
            4 * 3600 * S,
            12 * 3600 * S,
            24 * 3600 * S,
        ];
        let length = (self.to_ns - self.from_ns).max(1);
        let fits = |step: &i64| length / step < MOST_TIMES;
        // Longer than a week: as many days as it takes.
        let days = || (length / MOST_TIMES / (24 * 3600 * S) + 1) * 24 * 3600 * S;
        let step = steps.into_iter().chain(long).find(fits).unwrap_or_else(days);
        let first = self.from_ns.div_euclid(step) + i64::from(self.from_ns.rem_euclid(step) > 0);
        (first..)
            .map(|k| k * step)
            .take_while(|t_ns| *t_ns <= self.to_ns)
            .map(|t_ns| (t_ns, words(t_ns, step < S)))
            .collect()
    }
}

fn words(t_ns: i64, with_tenths: bool) -> String {
    match with_tenths {
        true => super::units::moment(t_ns),
        false => whole(t_ns.unsigned_abs() / 1_000_000_000),
    }
}

/// An axis of values from 0 on, or by powers of ten where few values are far above all others.
#[derive(Debug, Clone, Copy)]
pub(super) struct ValueAxis {
    range: (f64, f64),
    is_log: bool,
    top: f64,
    bottom: f64,
}

impl ValueAxis {
    /// From `top` to `bottom`, units from above, for values from `least` to `most`, most of which are about `middle`.
    pub(super) fn new((least, middle, most): (f64, f64, f64), top: f64, bottom: f64) -> Self {
        let is_log = least > 0.0 && most > 30.0 * middle;
        let range = match is_log {
            true => (10_f64.powf(least.log10().floor()), 10_f64.powf(most.log10().ceil())),
            false => (0.0, if most > 0.0 { most * 1.05 } else { 1.0 }),
        };
        Self {
            range,
            is_log,
            top,
            bottom,
        }
    }

    /// Whether it goes by powers of ten.
    pub(super) fn is_log(&self) -> bool {
        self.is_log
    }

    /// Units from above.
    pub(super) fn y(&self, value: f64) -> f64 {
        let (least, most) = self.range;
        let share = match self.is_log {
            true => (value.max(least) / least).ln() / (most / least).ln(),
            false => value / most,
        };
        self.bottom - share.clamp(0.0, 1.0) * (self.bottom - self.top)
    }

    /// Values that are written beside it.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let (least, most) = self.range;
        if self.is_log {
            let decades = (most / least).log10().round() as i32;
            let every = (decades / 6 + 1) as usize;
            return (0..=decades).step_by(every).map(|k| least * 10_f64.powi(k)).collect();
        }
        let size = 10_f64.powf((most / 5.0).log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|k| k * size)
            .into_iter()
            .find(|step| most / step <= 5.5);
        let step = step.unwrap_or(most);
        (0..=6)
            .map(|k| f64::from(k) * step)
            .take_while(|value| *value <= most)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn words_beside_an_axis_never_touch(from_ns in 0..(1_i64 << 60), length in 1..(1_i64 << 60)) {
            let axis = TimeAxis { from_ns, to_ns: from_ns + length };
            let ticks = axis.ticks();
            prop_assert!(ticks.len() <= 9);
            // A word of ten letters takes less than 70 units.
            for pair in ticks.windows(2) {
                prop_assert!(axis.x(pair[1].0) - axis.x(pair[0].0) >= (RIGHT - LEFT) / 8.001);
            }
        }

        #[test]
        fn values_are_drawn_in_the_plot(least in 0.0..1.0_f64, more in 0.0..1e6_f64, share in 0.0..1.0_f64) {
            let axis = ValueAxis::new((least, least + share * more, least + more), 10.0, 200.0);
            for value in [least, least + more, 0.0] {
                prop_assert!((10.0..=200.0).contains(&axis.y(value)));
            }
            prop_assert!((1..=8).contains(&axis.ticks().len()), "{:?}", axis.ticks());
        }
    }

    #[test]
    fn a_moment_is_at_its_place() {
        let axis = TimeAxis {
            from_ns: 0,
            to_ns: 20_000_000_000,
        };
        let words: Vec<String> = axis.ticks().into_iter().map(|(_, words)| words).collect();
        assert_eq!(words, ["00:00", "00:05", "00:10", "00:15", "00:20"]);
        assert_eq!(
            (axis.x(0), axis.x(10_000_000_000), axis.x(i64::MAX)),
            (LEFT, 430.0, RIGHT)
        );
    }
}
