//! A number over time, as means over a window.

use geometry::Rigid;
use nalgebra::{Matrix3, Vector3};

use super::LagError;

/// The most samples of a signal.
const MOST: usize = 200_000;
/// Samples within so many windows take part.
const REACH: f64 = 4.0;

/// A signal that is read through a window.
#[derive(Debug, Clone)]
pub(super) struct Smooth {
    times: Vec<f64>,
    values: Vec<f64>,
    window_s: f64,
}

impl Smooth {
    pub(super) fn new(signal: &'static str, samples: &[(f64, f64)], window_s: f64) -> Result<Self, LagError> {
        checked(signal, samples)?;
        let times: Vec<f64> = samples.iter().map(|s| s.0).collect();
        let step_s = fit::median(times.windows(2).map(|pair| pair[1] - pair[0]).collect());
        if step_s > window_s {
            return Err(LagError::Window {
                signal,
                step_s,
                window_s,
            });
        }
        Ok(Self {
            times,
            values: samples.iter().map(|s| s.1).collect(),
            window_s,
        })
    }

    /// First and last time.
    pub(super) fn span(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// Mean of all values.
    pub(super) fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// Value and speed at a time: of the straight line that fits the samples about it, weighted by a normal curve.
    pub(super) fn at(&self, t: f64) -> (f64, f64) {
        let reach = REACH * self.window_s;
        let low = self.times.partition_point(|x| *x < t - reach);
        let high = self.times.partition_point(|x| *x <= t + reach);
        let (mut w, mut wd, mut wdd, mut wv, mut wdv) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for i in low..high {
            let d = (self.times[i] - t) / self.window_s;
            let weight = (-0.5 * d * d).exp();
            w += weight;
            wd += weight * d;
            wdd += weight * d * d;
            wv += weight * self.values[i];
            wdv += weight * d * self.values[i];
        }
        let determinant = w * wdd - wd * wd;
        if determinant > 1e-6 * w * w {
            let value = (wdd * wv - wd * wdv) / determinant;
            return (value, (w * wdv - wd * wv) / determinant / self.window_s);
        }
        // In a gap wider than the window: the straight line between the two samples about it.
        let i = self.times.partition_point(|x| *x < t).clamp(1, self.times.len() - 1);
        let slope = (self.values[i] - self.values[i - 1]) / (self.times[i] - self.times[i - 1]);
        (self.values[i - 1] + slope * (t - self.times[i - 1]), slope)
    }
}

/// Refuses a signal of too few samples, times that do not rise and numbers that are none.
pub(super) fn checked(signal: &'static str, samples: &[(f64, f64)]) -> Result<(), LagError> {
    if !(20..=MOST).contains(&samples.len()) {
        return Err(LagError::Count {
            signal,
            found: samples.len(),
        });
    }
    for (index, (t_s, value)) in samples.iter().copied().enumerate() {
        let rises = index == 0 || t_s > samples[index - 1].0;
        if !(rises && t_s.is_finite() && value.is_finite()) {
            return Err(LagError::Sample {
                signal,
                index,
                t_s,
                value,
            });
        }
    }
    Ok(())
}

/// The way of poses along the direction in which they moved most, mm from their mean: the signal of a marker's
/// motion. The sign is that of
/// the direction's largest part.
pub fn principal_motion<To, From>(timed: &[(f64, Rigid<To, From>)]) -> Vec<(f64, f64)> {
    let places: Vec<Vector3<f64>> = timed.iter().map(|(_, pose)| pose.translation_mm().into()).collect();
    let mean = places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
    let outer = places.iter().map(|p| (p - mean) * (p - mean).transpose());
    let eigen = outer.sum::<Matrix3<f64>>().symmetric_eigen();
    let along = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    let along = along * along[along.iamax()].signum();
    timed
        .iter()
        .zip(&places)
        .map(|((t, _), p)| (*t, along.dot(&(p - mean))))
        .collect()
}
