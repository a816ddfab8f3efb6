//! How much each place looks like part of a bright line: dark, bright, dark along the beam, and bright along the line.

use super::grid::{Grid, normal};

/// Slopes of lines that are tried, mm of depth a mm of width, to each side: half way between two, a line of
/// [`super::Options::along_mm`] is off by less than the pulse.
const SLOPES: [f64; 6] = [0.0, 0.3, 0.6, 1.0, 1.45, 2.0];
/// What is held against an echo begins that far from its middle, mm: beyond the flanks of a pulse at 5 MHz and more.
pub(super) const FLANK_MM: f64 = 0.8;
/// And is as long, mm.
const BESIDE_MM: f64 = 1.5;

/// For each place of the grid the line through it that stands out most.
pub(super) struct Ridges {
    /// By how many grey levels the line is brighter than what lies above and below, the lesser of both.
    pub(super) contrast: Vec<f32>,
    /// Its slope, mm of depth a mm of width.
    slope: Vec<u8>,
}

impl Ridges {
    /// Lines are averaged along themselves by a normal curve of `along_mm`.
    ///
    /// An oblique line smoothed across the beams would vanish: so the mean is taken along each of a fan of slopes.
    /// That is what an oriented second derivative does, with the lesser of two contrasts in place of their sum, which
    /// an edge would have as well (Frangi 1998 and Hacihaliloglu 2009 meet it by eigenvalues and by phase).
    pub(super) fn new(grid: &Grid, along_mm: f64) -> Self {
        let weights = normal(along_mm / grid.wide_mm);
        let mut ridges = Self {
            contrast: vec![0.0; grid.grey.len()],
            slope: vec![0; grid.grey.len()],
        };
        let mut mean = vec![0.0_f32; grid.depths];
        let mut sums = vec![0.0_f64; grid.depths + 1];
        for (which, slope) in (0_u8..).zip(slopes()) {
            for beam in 0..grid.beams {
                along(grid, beam, slope, &weights, &mut mean);
                ridges.hold(grid, beam, which, &mean, &mut sums);
            }
        }
        ridges
    }

    /// The slope of the line through a place.
    pub(super) fn slope(&self, at: usize) -> f64 {
        slopes().nth(usize::from(self.slope[at])).unwrap_or(0.0)
    }

    /// Holds the contrasts of one beam and slope against the best so far.
    fn hold(&mut self, grid: &Grid, beam: usize, which: u8, mean: &[f32], sums: &mut [f64]) {
        let slope = slopes().nth(usize::from(which)).unwrap_or(0.0);
        let shown = &grid.shown[beam];
        // Sums from the top, so that the mean of any stretch is one difference.
        sums[shown.start] = 0.0;
        for row in shown.clone() {
            sums[row + 1] = sums[row] + f64::from(mean[row]);
        }
        // Along the beam an oblique echo is broader.
        let flank = (FLANK_MM * slope.hypot(1.0) / grid.step_mm).round().max(2.0) as usize;
        let beside = (BESIDE_MM / grid.step_mm).round().max(2.0) as usize;
        let part = 1.0 / beside as f64;
        let first = beam * grid.depths;
        for row in shown.start + flank + beside..shown.end.saturating_sub(flank + beside) {
            let above = (sums[row - flank] - sums[row - flank - beside]) * part;
            let below = (sums[row + flank + beside] - sums[row + flank]) * part;
            let contrast = mean[row] - above.max(below) as f32;
            if contrast > self.contrast[first + row] {
                self.contrast[first + row] = contrast;
                self.slope[first + row] = which;
            }
        }
    }
}

fn slopes() -> impl Iterator<Item = f64> {
    SLOPES.iter().copied().chain(SLOPES[1..].iter().map(|slope| -slope))
}

/// The mean of a beam and its neighbours along lines of a slope.
fn along(grid: &Grid, beam: usize, slope: f64, weights: &[f32], mean: &mut [f32]) {
    mean.fill(0.0);
    let reach = (weights.len() / 2) as i64;
    let mut sum = 0.0_f32;
    for (k, weight) in (-reach..=reach).zip(weights) {
        let Some(other) = usize::try_from(beam as i64 + k)
            .ok()
            .filter(|other| *other < grid.beams)
        else {
            continue;
        };
        // To whole samples: what is lost is below the step, and as much to either side.
        let shift = (slope * k as f64 * grid.wide_mm / grid.step_mm).round() as i64;
        let from = usize::try_from(shift).unwrap_or(0);
        let to = usize::try_from(-shift).unwrap_or(0);
        let line = grid.beam(other);
        if from < line.len() && to < line.len() {
            for (mean, grey) in mean[to..].iter_mut().zip(&line[from..]) {
                *mean += weight * grey;
            }
        }
        sum += weight;
    }
    mean.iter_mut().for_each(|mean| *mean /= sum);
}
