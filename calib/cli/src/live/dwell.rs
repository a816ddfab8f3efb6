//! Where a recorded tip stands still: stretches of time in which its speed is below a bound.
//!
//! The speed at a sample is the distance of the mean places of the tip in the window behind it and in the window before it, over the time
//! between their means: what trembles about one place has none. A stretch is as long as the speed stays below the bound, so that a
//! slow drift is one long stretch, which [`super::touched`] then refuses for how far it goes, and not many short ones.

use std::ops::Range;

use geometry::{Marker, Point, Rigid, Tracker, Vector};

/// The least length of a window, s, and the least number of samples in one.
const WINDOW_S: f64 = 0.2;
const WINDOW_SAMPLES: usize = 4;

/// A pose of the marker, and where its tip is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Which frame of the recording it is, from 0.
    pub(crate) frame: usize,
    pub(crate) t_s: f64,
    pub(crate) tip: Point<Tracker>,
    pub(crate) pose: Rigid<Tracker, Marker>,
}

/// What is taken for standing still.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Still {
    pub(crate) most_mm_s: f64,
    /// For at least so long, s.
    pub(crate) least_s: f64,
}

/// The window of a recording, s: at least four samples.
pub(crate) fn window_s(samples: &[Sample]) -> f64 {
    let mut steps: Vec<f64> = samples.windows(2).map(|w| w[1].t_s - w[0].t_s).collect();
    steps.sort_by(f64::total_cmp);
    let middle = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    f64::max(WINDOW_S, (WINDOW_SAMPLES as f64 + 0.5) * middle)
}

/// The stretches in which the tip stands still, in order. Times must rise. Where nothing is seen for a window, a stretch ends.
pub(crate) fn stretches(samples: &[Sample], still: Still) -> Vec<Range<usize>> {
    let window = window_s(samples);
    let speeds = speeds(samples, window);
    let goes_on = |i: usize| i > 0 && samples[i].t_s - samples[i - 1].t_s <= window;
    let mut found: Vec<Range<usize>> = Vec::new();
    for (i, speed) in speeds.iter().enumerate() {
        // A NaN is not still.
        if speed.is_nan() || *speed > still.most_mm_s {
            continue;
        }
        match found.last_mut() {
            Some(last) if last.end == i && goes_on(i) => last.end = i + 1,
            _ => found.push(i..i + 1),
        }
    }
    let long = |r: &Range<usize>| samples[r.end - 1].t_s - samples[r.start].t_s >= still.least_s;
    found.into_iter().filter(long).collect()
}

/// The speed at each sample, mm/s; NaN where a window has too few samples.
fn speeds(samples: &[Sample], window: f64) -> Vec<f64> {
    let origin = samples.first().map_or(Point::new(0.0, 0.0, 0.0), |s| s.tip);
    // Sums of places and times up to each sample.
    let mut sums = vec![(Vector::<Tracker>::new(0.0, 0.0, 0.0), 0.0)];
    for s in samples {
        let (place, time) = sums[sums.len() - 1];
        sums.push((place + (s.tip - origin), time + (s.t_s - samples[0].t_s)));
    }
    let mean = |r: Range<usize>| {
        let n = r.len();
        let share = 1.0 / n as f64;
        let (place, time) = (
            (sums[r.end].0 - sums[r.start].0) * share,
            (sums[r.end].1 - sums[r.start].1) * share,
        );
        (n >= WINDOW_SAMPLES).then_some((place, time))
    };
    let (mut first, mut end) = (0, 0);
    let one = |i: usize| {
        let t = samples[i].t_s;
        while samples[first].t_s <= t - window {
            first += 1;
        }
        while end < samples.len() && samples[end].t_s <= t + window {
            end += 1;
        }
        let (Some(before), Some(after)) = (mean(first..i + 1), mean(i..end)) else {
            return f64::NAN;
        };
        (after.0 - before.0).norm() / (after.1 - before.1)
    };
    (0..samples.len()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples at 50 Hz of a tip that goes where `at` says.
    fn samples(seconds: f64, at: impl Fn(f64) -> [f64; 3]) -> Vec<Sample> {
        let one = |i: usize| {
            let t_s = i as f64 / 50.0;
            let [x, y, z] = at(t_s);
            Sample {
                frame: i,
                t_s,
                tip: Point::new(x, y, z),
                pose: Rigid::identity(),
            }
        };
        (0..(seconds * 50.0) as usize).map(one).collect()
    }

    fn found(samples: &[Sample]) -> Vec<[f64; 2]> {
        let still = Still {
            most_mm_s: 2.0,
            least_s: 1.0,
        };
        let each = stretches(samples, still).into_iter();
        each.map(|r| [samples[r.start].t_s, samples[r.end - 1].t_s]).collect()
    }

    /// Two seconds at one place, a second of motion, two at another.
    fn two(t: f64) -> [f64; 3] {
        [40.0 * (t - 2.0).clamp(0.0, 1.0), 0.0, 1500.0]
    }

    #[test]
    fn standing_still_is_found_to_a_window() {
        let found = found(&samples(5.0, two));
        assert_eq!(found.len(), 2, "{found:?}");
        for (found, truth) in found.iter().zip([[0.0, 2.0], [3.0, 5.0]]) {
            let near = found[0] - truth[0] >= -1e-9 && truth[1] - found[1] >= -1e-9;
            // Two windows of 0.2 s at either end at most.
            assert!(
                near && found[0] - truth[0] <= 0.4 && truth[1] - found[1] <= 0.4,
                "{found:?}"
            );
        }
    }

    #[test]
    fn a_slow_drift_is_one_stretch_and_trembling_is_still() {
        assert_eq!(found(&samples(6.0, |t| [1.5 * t, 0.0, 0.0])).len(), 1);
        assert_eq!(found(&samples(6.0, |t| [2.5 * t, 0.0, 0.0])).len(), 0);
        assert_eq!(found(&samples(6.0, |t| [0.3 * (70.0 * t).sin(), 0.0, 0.0])).len(), 1);
    }

    #[test]
    fn what_is_not_seen_ends_a_stretch_and_few_samples_are_none() {
        let mut gone = samples(5.0, |_| [0.0; 3]);
        gone.retain(|s| !(2.0..2.5).contains(&s.t_s));
        assert_eq!(found(&gone).len(), 2);
        assert!(found(&[]).is_empty() && found(&gone[..1]).is_empty() && found(&gone[..20]).is_empty());
    }
}
