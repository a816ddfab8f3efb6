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
mod score;
mod seeds;

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::kernel::Kernel;
use crate::points::Cloud;
use crate::solve::{Ended, Exact, Solver, Stage, State};

use distinct::distinct;
use score::Scorer;
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
            pairs: 15,
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

/// The seeds of least cost so far.
struct Best {
    most: usize,
    /// The worst on top; of equal ones that which came last.
    heap: BinaryHeap<Scored>,
    came: usize,
}

struct Scored {
    cost: f64,
    came: usize,
    state: State,
}

impl Ord for Scored {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.came.cmp(&other.came))
    }
}
impl PartialOrd for Scored {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Scored {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Scored {}

impl Best {
    fn of(most: usize) -> Self {
        Self {
            most,
            heap: BinaryHeap::new(),
            came: 0,
        }
    }

    /// What a seed must cost less than.
    fn limit(&self) -> f64 {
        let is_full = self.heap.len() == self.most;
        self.heap
            .peek()
            .filter(|_| is_full)
            .map_or(f64::INFINITY, |worst| worst.cost)
    }

    fn offer(&mut self, cost: f64, state: State) {
        if cost >= self.limit() {
            return;
        }
        if self.heap.len() == self.most {
            self.heap.pop();
        }
        self.came += 1;
        self.heap.push(Scored {
            cost,
            came: self.came,
            state,
        });
    }

    fn in_order(self) -> Vec<(f64, State)> {
        self.heap
            .into_sorted_vec()
            .into_iter()
            .map(|s| (s.cost, s.state))
            .collect()
    }
}

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
        steps: 6,
        settled_mm: 0.1,
    };
    let last = Stage {
        kernel: Kernel::Tukey(end),
        steps: 6,
        settled_mm: 0.05,
        ..wide
    };
    [wide, last]
}

/// The stages of one start alone: those on a sample, which narrow the kernel from afar, and two and two on all points.
pub(crate) fn long_stages(end: f64) -> [[Stage; 2]; 3] {
    let wide = |m: f64| Stage {
        kernel: Kernel::Wide(m),
        is_facing: false,
        steps: 4,
        settled_mm: 0.4,
    };
    [[wide(40.0), wide(20.0)], [wide(10.0), wide(5.0)], polish_stages(end)]
}

/// So many fits must lead to a pose that a verdict takes: one as wide as it was missed by all of them with a chance of 5 %.
pub(crate) const LEAST_HITS: usize = 3;

/// By how many times more is tried where fewer fits led to the best pose.
const MORE: usize = 4;

impl Effort {
    /// The same and more, of other draws.
    fn more(&self) -> Self {
        Self {
            seeds: self.seeds.saturating_mul(MORE),
            pairs: self.pairs.saturating_mul(MORE),
            tried: self.tried.saturating_mul(MORE),
            seed: self.seed ^ 0x6d6f_7265,
            ..*self
        }
    }
}

impl Searched {
    /// Both searches as one: what they found, each minimum once, with the fits of both.
    fn with(self, other: Self, radius_mm: f64) -> Self {
        let both = self.minima.into_iter().chain(other.minima);
        let both = both.map(|minimum| (minimum.ended.cost, minimum.ended, minimum.hits));
        Self {
            minima: distinct::ends(both.collect(), radius_mm, FINE_MM),
            seeds: self.seeds + other.seeds,
            fits: self.fits + other.fits,
        }
    }
}

/// Searches, and once more with other draws and more of them where the best pose was hardly found: a second time only, as who searches until
/// a pose came often enough knows less by that.
pub(crate) fn search(
    solver: &Solver<'_>,
    exact: &Exact<'_>,
    cloud: &Cloud,
    seeds: &Seeds<'_>,
    effort: &Effort,
) -> Searched {
    let searched = once(solver, exact, cloud, seeds, effort);
    if searched.minima.first().is_some_and(|best| best.hits >= LEAST_HITS) {
        return searched;
    }
    searched.with(once(solver, exact, cloud, seeds, &effort.more()), cloud.radius_mm)
}

fn once(solver: &Solver<'_>, exact: &Exact<'_>, cloud: &Cloud, seeds: &Seeds<'_>, effort: &Effort) -> Searched {
    let sample = cloud.thinned(effort.sample);
    let blunt = solver.blunt(&sample);
    let scorer = Scorer::new(solver, &sample);
    let (mut best, mut count) = (Best::of(effort.tried), 0);
    seeds.each(effort, &mut |state| {
        count += 1;
        let limit = best.limit();
        best.offer(scorer.score(&state, limit), state);
    });
    let scored = best.in_order();
    let stages = rough_stages(solver.end);
    let rough: Vec<(f64, State)> = scored
        .iter()
        .filter_map(|(_, state)| solver.through(&sample, &blunt, *state, &stages))
        .map(|(state, cost)| (cost, state))
        .collect();
    let fits = rough.len();
    // Distinct ones only: the best four hundred are mostly one minimum, and the others are what a verdict needs to know of.
    let mut rough = distinct(rough, cloud.radius_mm, ROUGH_MM);
    rough.truncate(effort.polished);
    let stages = polish_stages(solver.end);
    let polished = rough.iter().filter_map(|(_, state, hits)| {
        let (state, cost) = solver.near(cloud, *state, &stages)?;
        Some((cost, state, *hits))
    });
    let mut polished = distinct::merged(polished.collect(), cloud.radius_mm, FINE_MM);
    polished.truncate(effort.ends);
    let ended = polished.iter().filter_map(|(_, state, hits)| {
        let ended = solver.end(cloud, exact, *state)?;
        Some((ended.cost, ended, *hits))
    });
    Searched {
        minima: distinct::ends(ended.collect(), cloud.radius_mm, FINE_MM),
        seeds: count,
        fits,
    }
}
