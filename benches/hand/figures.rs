//! Figures of a case, and the rows of the tables.

use hand::Outcome;

use crate::study::Done;

/// A median with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Median {
    /// The median.
    pub value: f64,
    /// Between these it lies in 95 of 100 studies.
    pub interval: [f64; 2],
}

/// What came of a case.
#[derive(Debug, Clone, Copy)]
pub struct Figures {
    /// Share of tasks that arrived.
    pub arrived: f64,
    /// Time to target, s; of all tasks, those that were given up with the time until then.
    pub time_s: Median,
    /// True miss, mm.
    pub miss_mm: Median,
    /// 95 of 100 misses are below this, mm.
    pub miss_95_mm: f64,
    /// Median of the predicted error, mm.
    pub predicted_mm: f64,
    /// Share of misses within the predicted error.
    pub within: f64,
    /// The same with half a millimetre besides.
    pub within_half: f64,
    /// Share of aims that are where they were shown, to within the predicted error.
    pub as_predicted: f64,
    /// Mean number of strokes, and of glances.
    pub strokes: f64,
    /// Mean number of glances.
    pub glances: f64,
}

impl Median {
    /// By ranks, without an assumption on the distribution: between `n/2 -+ 1.96 sqrt(n)/2` (Conover 1999, 3.2).
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let at = |rank: f64| values[(rank.round().max(0.0) as usize).min(values.len() - 1)];
        let half = 1.96 * n.sqrt() / 2.0;
        let middle = (n - 1.0) / 2.0;
        Self {
            value: 0.5 * (at(middle.floor()) + at(middle.ceil())),
            interval: [at(middle - half), at(middle + half)],
        }
    }

    fn words(&self, decimals: usize) -> String {
        let [low, high] = self.interval;
        format!("{:.decimals$} ({low:.decimals$}-{high:.decimals$})", self.value)
    }
}

impl Figures {
    /// Of the tasks of a case.
    pub fn of(outcomes: &[Outcome]) -> Self {
        let all = |of: fn(&Outcome) -> f64| -> Vec<f64> { outcomes.iter().map(of).collect() };
        let mean = |of: fn(&Outcome) -> f64| all(of).iter().sum::<f64>() / outcomes.len() as f64;
        let mut misses = all(|o| o.miss_mm);
        misses.sort_by(f64::total_cmp);
        Self {
            arrived: mean(|o| f64::from(u8::from(o.is_arrived))),
            time_s: Median::of(all(|o| o.time_s)),
            miss_mm: Median::of(all(|o| o.miss_mm)),
            miss_95_mm: misses[(0.95 * (misses.len() - 1) as f64).round() as usize],
            predicted_mm: Median::of(all(|o| o.predicted_mm)).value,
            within: mean(|o| f64::from(u8::from(o.is_within()))),
            within_half: mean(|o| f64::from(u8::from(o.miss_mm <= o.predicted_mm + 0.5))),
            as_predicted: mean(|o| f64::from(u8::from(o.is_as_predicted()))),
            strokes: mean(|o| o.strokes as f64),
            glances: mean(|o| o.glances as f64),
        }
    }
}

/// The head of the tables.
pub const HEAD: &str = "| display | noise, mm | added lag, ms | | time to target, s | true miss, mm | \
    95 of 100 misses below, mm | predicted error, mm | miss within it | within it + 0.5 mm | aim as predicted | strokes | glances |\n\
    |---|---|---|---|---|---|---|---|---|---|---|---|---|";

/// A row of the tables.
pub fn row(done: &Done) -> String {
    let (case, f) = (&done.case, Figures::of(&done.outcomes));
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let given_up = match f.arrived < 1.0 {
        true => format!(", {} given up", percent(1.0 - f.arrived)),
        false => String::new(),
    };
    format!(
        "| {} | {} | {} | {}{given_up} | {} | {} | {:.2} | {:.2} | {} | {} | {} | {:.1} | {:.1} |",
        case.display.word(),
        case.noise_mm,
        case.lag_ms,
        case.variant,
        f.time_s.words(2),
        f.miss_mm.words(2),
        f.miss_95_mm,
        f.predicted_mm,
        percent(f.within),
        percent(f.within_half),
        percent(f.as_predicted),
        f.strokes,
        f.glances,
    )
}
