//! What other software does with arrivals.

use super::links::Link;

const FRAMES: usize = 20;

/// The least squares line of arrivals over numbers of the last 20 frames, at the newest; the arrival itself while there are fewer.
pub(super) fn line_over_20(link: &Link) -> Vec<f64> {
    let newest = |i: usize| {
        let Some(first) = (i + 1).checked_sub(FRAMES) else {
            return link.arrival[i];
        };
        let numbers = link.number[first..=i].iter().map(|n| *n as f64);
        let pairs: Vec<(f64, f64)> = numbers.zip(link.arrival[first..=i].iter().copied()).collect();
        let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / FRAMES as f64;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let across: f64 = pairs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        let along: f64 = pairs.iter().map(|p| (p.0 - x).powi(2)).sum();
        y + across / along * (link.number[i] as f64 - x)
    };
    (0..link.arrival.len()).map(newest).collect()
}

const HALF_LIFE_S: f64 = 90.0;

/// Offset and period by recursive least squares of arrivals over numbers, with exponential forgetting.
pub(super) fn recursive(link: &Link, rate_hz: f64) -> Vec<f64> {
    let forget = 2_f64.powf(-1.0 / (rate_hz * HALF_LIFE_S));
    let (first_number, first) = (link.number[0], link.arrival[0]);
    let mut weights = [0.0, 1.0 / rate_hz];
    // The inverse of the information: nothing is known at first.
    let mut inverse = [[1e10, 0.0], [0.0, 1e10]];
    let frames = link.number.iter().zip(&link.arrival);
    let stamps = frames.map(|(number, arrival)| {
        let u = [1.0, (number - first_number) as f64];
        let pu = inverse.map(|row| row[0] * u[0] + row[1] * u[1]);
        let gain = pu.map(|p| p / (forget + u[0] * pu[0] + u[1] * pu[1]));
        let miss = arrival - first - (weights[0] * u[0] + weights[1] * u[1]);
        weights = [weights[0] + gain[0] * miss, weights[1] + gain[1] * miss];
        for (row, g) in inverse.iter_mut().zip(gain) {
            *row = [(row[0] - g * pu[0]) / forget, (row[1] - g * pu[1]) / forget];
        }
        first + weights[0] * u[0] + weights[1] * u[1]
    });
    stamps.collect()
}
