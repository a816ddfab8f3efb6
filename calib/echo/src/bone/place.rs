//! Where between the samples a line lies, and how sure that is.

use nalgebra::{Matrix3, Vector3};

use super::grid::{Grid, normal};
use super::trace::Line;

/// Half of the window in which a line's bow and its scatter are taken, mm.
const WINDOW_MM: f64 = 2.5;
/// The profile is taken this far to each side of the line, mm.
const REACH_MM: f64 = 2.5;
/// The top is looked for this far from where the line was traced, mm.
const TOP_MM: f64 = 0.8;
/// How far a surface may lie from the top of its echo, as a share of the echo's deviation. Neighbours share it.
const WITHIN_ECHO: f64 = 0.15;
/// A profile falls to half of its height at 1.177 deviations.
const HALF_HEIGHT: f64 = 1.177;

/// A place of a line.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    /// From the face, mm.
    pub(super) depth_mm: f64,
    /// Slope of the line there, mm of depth a mm of width at half of the image's depth.
    pub(super) slope: f64,
    /// Deviation of the echo's profile along the beam, mm.
    pub(super) echo_mm: f64,
    /// Standard deviation along the beam, mm.
    pub(super) sigma_mm: f64,
}

/// The places of a line, beam by beam; `None` where its echo has no top.
///
/// The mean of neighbouring beams is taken along the line itself, bow and all, so that neither slope nor bow shifts it.
pub(super) fn places(grid: &Grid, line: &Line, along_mm: f64) -> Vec<Option<Placed>> {
    let rows: Vec<Option<f64>> = line.rows.iter().map(|row| Some(*row as f64)).collect();
    let traced: Vec<f64> = bows(&rows, grid.wide_mm)
        .iter()
        .zip(&line.rows)
        .map(|(bow, row)| bow.map_or(*row as f64, |bow| bow.row))
        .collect();
    let weights = normal(along_mm / grid.wide_mm);
    let tops: Vec<Option<Top>> = (0..rows.len())
        .map(|i| top(grid, line.first, &traced, i, &weights))
        .collect();
    let found: Vec<Option<f64>> = tops.iter().map(|top| Some(top.as_ref()?.row)).collect();
    let bows = bows(&found, grid.wide_mm);
    tops.iter()
        .zip(bows)
        .map(|(top, bow)| {
            let (top, bow) = (top.as_ref()?, bow?);
            // A twelfth: of a place that is known to a sample.
            let own_mm = (bow.variance + 1.0 / 12.0).sqrt() * grid.step_mm;
            let echo_mm = top.deviation * grid.step_mm;
            Some(Placed {
                depth_mm: top.row * grid.step_mm,
                slope: bow.slope * grid.step_mm / grid.wide_mm,
                echo_mm,
                sigma_mm: own_mm.hypot(WITHIN_ECHO * echo_mm),
            })
        })
        .collect()
}

/// The top of an echo, in samples.
struct Top {
    row: f64,
    deviation: f64,
}

fn top(grid: &Grid, first: usize, traced: &[f64], i: usize, weights: &[f32]) -> Option<Top> {
    let reach = (REACH_MM / grid.step_mm).round() as i64;
    let half = (weights.len() / 2) as i64;
    let mut profile = vec![0.0_f64; (2 * reach + 1) as usize];
    let mut sum = 0.0;
    for (k, weight) in (-half..=half).zip(weights) {
        let Some(other) = usize::try_from(i as i64 + k).ok().filter(|other| *other < traced.len()) else {
            continue;
        };
        let (beam, shown) = (grid.beam(first + other), &grid.shown[first + other]);
        let low = traced[other].floor();
        let part = (traced[other] - low) as f32;
        for (value, at) in profile.iter_mut().zip(-reach..) {
            let row = (low as i64 + at).clamp(shown.start as i64, shown.end as i64 - 2).max(0) as usize;
            let grey = beam[row] + part * (beam.get(row + 1)? - beam[row]);
            *value += f64::from(weight * grey);
        }
        sum += f64::from(*weight);
    }
    profile.iter_mut().for_each(|value| *value /= sum);
    let middle = reach as usize;
    let most = ((TOP_MM / grid.step_mm).round() as usize).min(middle - 1);
    let near = middle - most..=middle + most;
    let at = near.max_by(|a, b| profile[*a].total_cmp(&profile[*b]))?;
    let (a, b, c) = (profile[at - 1], profile[at], profile[at + 1]);
    let bend = a - 2.0 * b + c;
    let is_top = bend < 0.0 && b >= a && b >= c;
    is_top.then(|| Top {
        row: traced[i] + at as f64 - middle as f64 + 0.5 * (a - c) / bend,
        deviation: deviation(&profile, at),
    })
}

/// From the width at half of the height over the higher of both feet: muscle above a bone is not black.
fn deviation(profile: &[f64], top: usize) -> f64 {
    let foot = |side: &[f64]| side.iter().copied().fold(f64::INFINITY, f64::min);
    let half = 0.5 * (profile[top] + foot(&profile[..top]).max(foot(&profile[top..])));
    let above = profile[..top].iter().rev().take_while(|value| **value > half).count();
    let below = profile[top..].iter().take_while(|value| **value > half).count();
    ((above + below) as f64 / 2.0 / HALF_HEIGHT).max(0.5)
}

/// A parabola through a line's neighbouring places.
#[derive(Clone, Copy)]
struct Bow {
    row: f64,
    /// Samples a beam.
    slope: f64,
    /// Of the places about it.
    variance: f64,
}

fn bows(rows: &[Option<f64>], wide_mm: f64) -> Vec<Option<Bow>> {
    let reach = (WINDOW_MM / wide_mm).round().max(3.0) as usize;
    (0..rows.len()).map(|i| bow(rows, i, reach)).collect()
}

fn bow(rows: &[Option<f64>], i: usize, reach: usize) -> Option<Bow> {
    let (from, to) = (i.saturating_sub(reach), (i + reach + 1).min(rows.len()));
    let near = || (from..to).filter_map(|j| Some((j as f64 - i as f64, rows[j]?)));
    let basis = |x: f64| Vector3::new(1.0, x / reach as f64, (x / reach as f64).powi(2));
    let (mut normal, mut right, mut n) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for (x, row) in near() {
        normal += basis(x) * basis(x).transpose();
        right += basis(x) * row;
        n += 1.0;
    }
    if n < 5.0 {
        return None;
    }
    let curve = normal.cholesky()?.solve(&right);
    let squares: f64 = near().map(|(x, row)| (row - curve.dot(&basis(x))).powi(2)).sum();
    Some(Bow {
        row: curve[0],
        slope: curve[1] / reach as f64,
        variance: squares / (n - 3.0),
    })
}
