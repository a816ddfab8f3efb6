//! The smooth field of a set of voxels.

use nalgebra::Vector3;

use super::super::field::Field;
use super::super::spline::Spline;
use super::NoRegion;

/// More passes than these would blur an organ away.
const MOST_PASSES: usize = 32;

/// Passes of the weights 1/4, 1/2, 1/4 along each axis. A pass adds half a voxel's square to the variance; the cubic spline
/// itself has a third.
pub(super) fn passes(sigma: f64, spacing: &Vector3<f64>) -> Result<[usize; 3], NoRegion> {
    let passes = [0, 1, 2].map(|k| (2.0 * ((sigma / spacing[k]).powi(2) - 1.0 / 3.0)).max(0.0).round());
    let most = spacing.min() * (0.5 * MOST_PASSES as f64 + 1.0 / 3.0).sqrt();
    if !(sigma.is_finite() && sigma >= 0.0 && passes.iter().all(|p| *p <= MOST_PASSES as f64)) {
        return Err(NoRegion::Smoothing { found: sigma, most });
    }
    Ok(passes.map(|p| p as usize))
}

/// The indicator of voxels after passes along each axis.
pub(super) fn blurred(inside: &[bool], size: [usize; 3], passes: [usize; 3]) -> Vec<f32> {
    let mut values: Vec<f32> = inside.iter().map(|i| if *i { 1.0 } else { 0.0 }).collect();
    let strides = [1, size[0], size[0] * size[1]];
    for axis in 0..3 {
        for _ in 0..passes[axis] {
            let before = values.clone();
            for (n, value) in values.iter_mut().enumerate() {
                let at = n / strides[axis] % size[axis];
                let low = if at > 0 { before[n - strides[axis]] } else { 0.0 };
                let high = if at + 1 < size[axis] {
                    before[n + strides[axis]]
                } else {
                    0.0
                };
                *value = 0.25 * low + 0.5 * before[n] + 0.25 * high;
            }
        }
    }
    values
}

/// Samples of a voxel along each axis for its volume.
const SAMPLES: usize = 3;

/// The field of smoothed voxels, at the level of the same volume. `None` where a place overflows.
pub(super) fn spline(
    values: Vec<f32>,
    size: [usize; 3],
    origin: Vector3<f64>,
    spacing: Vector3<f64>,
    inside: &[bool],
) -> Option<Spline> {
    // Negative inside.
    let negative: Vec<f32> = values.iter().map(|v| -v).collect();
    let spline = Spline::new(size, origin, spacing, negative, 0.0)?;
    let level = level_of_volume(&spline, size, &values, inside);
    Some(spline.at_level(level))
}

/// The level below which as many samples lie as voxels are inside.
fn level_of_volume(spline: &Spline, size: [usize; 3], values: &[f32], inside: &[bool]) -> f64 {
    let [origin, last] = spline.corners();
    let spacing = Vector3::from_fn(|k, _| (last[k] - origin[k]) / (size[k] - 1) as f64);
    // Samples where all is flat need no spline: they are most of a crop.
    let wanted = SAMPLES.pow(3) * inside.iter().filter(|i| **i).count();
    let (mut whole, mut between) = (0, Vec::new());
    for n in 0..values.len() {
        let at = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]];
        match flat(values, size, at) {
            Some(true) => whole += SAMPLES.pow(3),
            Some(false) => {}
            None => between.extend((0..SAMPLES.pow(3)).map(|s| {
                let part = [s % SAMPLES, s / SAMPLES % SAMPLES, s / SAMPLES / SAMPLES];
                let by = |k: usize| at[k] as f64 - 0.5 + (part[k] as f64 + shift(n, k)) / SAMPLES as f64;
                spline.value(&(origin + Vector3::from_fn(|k, _| spacing[k] * by(k))))
            })),
        }
    }
    let rest = wanted.saturating_sub(whole).min(between.len().saturating_sub(1));
    if between.is_empty() {
        return -0.5;
    }
    let (below, level, _) = between.select_nth_unstable_by(rest, f64::total_cmp);
    // Half-way between the last sample inside and the first outside: small regions have many samples of one value.
    let last = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if last.is_finite() {
        0.5 * (last + *level)
    } else {
        *level
    }
}

/// Where in its part of the `n`th voxel a sample lies along an axis: other places in each (Roberts's sequence), as flat faces of a
/// label would have all samples at a few depths.
fn shift(n: usize, axis: usize) -> f64 {
    const STEPS: [f64; 3] = [
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_2,
        0.549_700_477_901_960_8,
    ];
    (n as f64 * STEPS[axis]).fract()
}

/// Whether all values around a voxel are 1, or all are 0.
fn flat(values: &[f32], size: [usize; 3], at: [usize; 3]) -> Option<bool> {
    let first = values[(at[2] * size[1] + at[1]) * size[0] + at[0]];
    for n in 0..125 {
        let by = [n % 5, n / 5 % 5, n / 25];
        let place = [0, 1, 2].map(|k| (at[k] + by[k]).saturating_sub(2).min(size[k] - 1));
        if values[(place[2] * size[1] + place[1]) * size[0] + place[0]] != first {
            return None;
        }
    }
    Some(first > 0.5)
}
