//! From many starts to distinct minima.
//!
//! 1. Seeds: poses around a guess, within the errors of landmarks, or, where nothing is known, all that lay two measured points on two
//!    places of the surface ([`pairs`]).
//! 2. Each is scored on a sample of the points, without a step.
//! 3. The best are fitted on that sample, by a narrowing kernel on the field.
//! 4. The best distinct ends of those are fitted on all points, and the best distinct ones of these on the surface itself.
//!
//! All that is drawn at random is drawn from numbers that a seed repeats, so that the same input gives the same bits.

mod distinct;
pub(crate) mod pairs;
mod seeds;

use geometry::Frame;

use crate::kernel::Kernel;
use crate::points::Cloud;
use crate::solve::{Ended, Exact, Solver, Stage, State};

pub(crate) use distinct::apart_mm;
use distinct::distinct;
pub(crate) use seeds::Seeds;

/// How much is tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Seeds that are scored around a guess or landmarks.
    pub seeds: usize,
    /// Pairs of measured points that are laid on all pairs of places of the surface, where nothing is known.
    pub pairs: usize,
    /// Places of the surface that they are laid on.
    pub places: usize,
    /// Points of the sample.
    pub sample: usize,
    /// Best seeds that are fitted on the sample.
    pub tried: usize,
    /// Best distinct ones of those that are fitted on all points.
    pub polished: usize,
    /// Best distinct ones of those that are fitted on the surface itself.
    pub ends: usize,
    /// Of all that is drawn at random.
    pub seed: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            seeds: 20_000,
            pairs: 100,
            places: 1000,
            sample: 48,
            tried: 400,
            polished: 40,
            ends: 8,
            seed: 1,
        }
    }
}

/// One minimum.
#[derive(Debug, Clone)]
pub(crate) struct Minimum {
    pub(crate) ended: Ended,
    /// Fits on the sample that led here.
    pub(crate) hits: usize,
}

/// What a search found.
pub(crate) struct Searched {
    /// Distinct minima, the least first.
    pub(crate) minima: Vec<Minimum>,
    /// Seeds that were scored.
    pub(crate) seeds: usize,
    /// Fits on the sample.
    pub(crate) fits: usize,
}

/// Two ends nearer than this are one minimum, mm at the points, while they are known on the sample only.
const ROUGH_MM: f64 = 4.0;
/// And at the end.
const FINE_MM: f64 = 1.0;

/// Stages on the sample.
fn rough_stages(end: f64) -> [Stage; 4] {
    let wide = |m: f64, steps: usize| Stage {
        kernel: Kernel::Wide(m),
        is_facing: false,
        steps,
        settled_mm: 0.3,
    };
    let last = Stage {
        kernel: Kernel::Tukey(2.0 * end),
        is_facing: true,
        steps: 4,
        settled_mm: 0.1,
    };
    [wide(10.0, 4), wide(5.0, 4), wide(3.0, 4), last]
}

/// Stages on all points.
fn polish_stages(end: f64) -> [Stage; 2] {
    let wide = Stage {
        kernel: Kernel::Wide(3.0),
        is_facing: true,
        steps: 8,
        settled_mm: 0.05,
    };
    let last = Stage {
        kernel: Kernel::Tukey(end),
        steps: 12,
        settled_mm: 0.02,
        ..wide
    };
    [wide, last]
}

/// Where a stage narrows a kernel from afar: for one start alone.
pub(crate) fn long_stages(end: f64) -> Vec<Stage> {
    let wide = |m: f64| Stage {
        kernel: Kernel::Wide(m),
        is_facing: false,
        steps: 5,
        settled_mm: 0.2,
    };
    let mut stages: Vec<Stage> = [40.0, 20.0, 10.0, 5.0].into_iter().map(wide).collect();
    stages.extend(polish_stages(end));
    stages
}

pub(crate) fn search<F: Frame>(solver: &Solver<'_, F>, cloud: &Cloud, seeds: &Seeds<'_>, effort: &Effort) -> Searched {
    let sample = cloud.thinned(effort.sample);
    let blunt = solver.blunt(&sample);
    let mut scored: Vec<(f64, State)> = Vec::new();
    seeds.each(effort, &mut |state| {
        let cost = score(solver, &sample, &blunt, &state);
        if cost.is_finite() {
            scored.push((cost, state));
        }
    });
    let count = scored.len();
    keep_best(&mut scored, effort.tried);
    let stages = rough_stages(solver.end);
    let rough: Vec<(f64, State)> = scored
        .iter()
        .filter_map(|(_, state)| solver.through(&sample, &blunt, *state, &stages))
        .map(|(state, cost)| (cost, state))
        .collect();
    let fits = rough.len();
    let mut rough = distinct(rough, cloud.radius_mm, ROUGH_MM);
    rough.truncate(effort.polished);
    let blunt = solver.blunt(cloud);
    let stages = polish_stages(solver.end);
    let polished = rough.iter().filter_map(|(_, state, hits)| {
        let (state, cost) = solver.through(cloud, &blunt, *state, &stages)?;
        Some((cost, state, *hits))
    });
    let mut polished = distinct::merged(polished.collect(), cloud.radius_mm, FINE_MM);
    polished.truncate(effort.ends);
    let exact = Exact::new(solver.surface, cloud.len());
    let ended = polished.iter().filter_map(|(_, state, hits)| {
        let ended = solver.end(cloud, &exact, *state)?;
        Some((ended.cost, ended, *hits))
    });
    Searched {
        minima: distinct::ends(ended.collect(), cloud.radius_mm, FINE_MM),
        seeds: count,
        fits,
    }
}

/// The `n` of least cost in order; ties by place, so that the order is the same on every run.
fn keep_best(scored: &mut Vec<(f64, State)>, n: usize) {
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    scored.truncate(n);
}

/// Width of the kernel that seeds are scored by, mm: about the distance of seeds.
const SCORE_MM: f64 = 6.0;

/// The cost of a seed on the sample, in squares of `SCORE_MM`.
fn score<F: Frame>(solver: &Solver<'_, F>, sample: &Cloud, blunt: &[f64], state: &State) -> f64 {
    let _ = blunt;
    let mut cost = 0.0;
    for i in 0..sample.len() {
        let p = state.turn * sample.places[i] + state.shift;
        let (d, n) = solver.field.look(&p);
        let faces = n.dot(&(state.turn * sample.beams[i])) <= solver.facing;
        let square = d * d;
        cost += sample.votes[i] * if faces { square / (square + SCORE_MM * SCORE_MM) } else { 1.0 };
    }
    for anchor in solver.anchors {
        let off = state.turn * anchor.from + state.shift - anchor.to;
        cost += off.norm_squared() / (anchor.sigma_mm * anchor.sigma_mm + SCORE_MM * SCORE_MM) / 3.0;
    }
    cost
}
