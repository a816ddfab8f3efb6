//! What speaks against a lag that fits best within the range: one beyond it that fits better, and two halves of the recording that disagree.

use super::{Fit, LEAST, LagError, STEPS};

/// So far beyond the range is looked, as a share of it.
const BEYOND: f64 = 2.0;
/// Two halves that are further apart than this many of their deviations come by chance 1 time in 1000.
const ONE_IN_1000: f64 = 3.290_5;
/// And from this on, 1 time in 20, their difference is in the deviation of the lag.
const ONE_IN_20: f64 = 1.960;

impl Fit<'_> {
    /// Refuses a lag where one beyond the range fits the samples that have poses there better.
    pub(super) fn not_beyond(&self, lag_s: f64) -> Result<(), LagError> {
        let most_s = self.options.most_s;
        let (first, last) = self.way.span();
        // The same samples for every lag: sums of squares over different ones do not compare.
        let wide = Fit {
            way: self.way,
            options: self.options,
            samples: self
                .samples
                .iter()
                .copied()
                .filter(|(t, _)| (first + BEYOND * most_s..=last - BEYOND * most_s).contains(t))
                .collect(),
            gross: 0,
        };
        // A recording that is hardly longer than the range has no poses beyond it.
        if wide.samples.len() < LEAST {
            return Ok(());
        }
        let step = most_s / STEPS as f64;
        let most = (BEYOND * STEPS as f64) as usize;
        let beyond = (STEPS + 1..=most).flat_map(|k| [k as f64 * step, -(k as f64 * step)]);
        let best = beyond.min_by(|a, b| wide.line(*a).squares.total_cmp(&wide.line(*b).squares));
        match best {
            Some(found_s) if wide.line(found_s).squares < wide.line(lag_s).squares => {
                Err(LagError::Beyond { lag_s, found_s, most_s })
            }
            _ => Ok(()),
        }
    }

    /// The deviation of the lag with what the two halves of the recording differ by; refused where that is no chance.
    pub(super) fn steady(&self, lag_s: f64, sigma_s: f64) -> Result<f64, LagError> {
        let middle = self.samples.len() / 2;
        let half = |samples: &[(f64, f64)]| {
            let part = Fit {
                way: self.way,
                options: self.options,
                samples: samples.to_vec(),
                gross: 0,
            };
            // Near the lag of all: a half of a motion that repeats itself may fit elsewhere as well.
            let reach = self.options.window_s.max(8.0 * sigma_s);
            let own_s = part.golden(lag_s - reach, lag_s + reach);
            (own_s, part.sigma(own_s, &part.line(own_s)))
        };
        // Two fits of fewer samples say nothing of the halves.
        if middle < LEAST {
            return Ok(sigma_s);
        }
        let (first, second) = (half(&self.samples[..middle]), half(&self.samples[middle..]));
        let apart = second.0 - first.0;
        // The halves share no sample, so their errors are independent.
        let deviations = apart.abs() / first.1.hypot(second.1).max(f64::MIN_POSITIVE);
        if deviations > ONE_IN_1000 {
            return Err(LagError::Drifts {
                first_s: first.0,
                second_s: second.0,
                deviations,
            });
        }
        Ok(match deviations > ONE_IN_20 {
            // At either end of the recording the lag is off by as much as the halves are apart.
            true => sigma_s.hypot(apart),
            false => sigma_s,
        })
    }
}
