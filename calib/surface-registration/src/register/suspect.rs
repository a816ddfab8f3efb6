//! Where in the order of the points the later ones pull at the pose most.

use crate::kernel::Kernel;
use crate::points::Cloud;
use crate::solve::{Matrix8, Noise, Problem, Say, Solver, State, Vector8};

/// Steps between places that are looked at, shares of all points; the first and the last place.
const STEP: f64 = 0.05;
const ENDS: [f64; 2] = [0.15, 0.85];
/// A part with fewer points, such as were taken by a probe held still as one, has no pose of its own.
pub(super) const LEAST_PART: f64 = 15.0;
/// The kernels of the scores, deviations: what lies so far off still has half of its greatest pull. The narrow one sees some millimetres,
/// the wide one a bone that moved so far that one part of the points is left out by the fit.
const SCORE_KERNELS: [f64; 2] = [6.0, 25.0];

/// What goes with the order of the points.
pub(super) struct Suspects {
    /// The greatest of each kind of score, with the number of points before its place.
    pub(super) greatest: Vec<(f64, usize)>,
    /// Places whose scores were computed, the fewer of both kernels'.
    pub(super) places: usize,
    /// Places with enough points before and after, whether their scores could be computed or not.
    pub(super) wide: usize,
    /// All points, such as were taken by a probe held still as one.
    pub(super) points: f64,
}

/// Looks at all places.
pub(super) fn suspects(solver: &Solver<'_>, cloud: &Cloud, noise: &Noise, state: &State) -> Suspects {
    let scored = SCORE_KERNELS.map(|kernel| suspect_by(solver, cloud, noise, state, Kernel::Wide(kernel)));
    let left = left_out(solver, cloud, noise, state);
    Suspects {
        greatest: scored.iter().filter_map(|scored| scored.best).chain(left).collect(),
        places: scored.iter().map(|scored| scored.places).min().unwrap_or(0),
        wide: scored.iter().map(|scored| scored.wide).min().unwrap_or(0),
        points: cloud.votes.iter().sum(),
    }
}

/// The scores by one kernel.
#[derive(Default)]
struct Scored {
    best: Option<(f64, usize)>,
    places: usize,
    wide: usize,
}

/// Where the shares of points that fit differ most before and after, by twice the square of their difference in its deviations: of a bone
/// that moved far the one part is left out, and gross errors know of no order.
fn left_out(solver: &Solver<'_>, cloud: &Cloud, noise: &Noise, state: &State) -> Option<(f64, usize)> {
    let problem = solver.on_field(cloud, noise);
    // Each point's vote, and as much of it as fits; of one beyond an open border it is not known whether it would.
    let fits = |i: usize| {
        let (s, _, say) = problem.residual(i, state);
        let vote = if say == Say::Beyond { 0.0 } else { cloud.votes[i] };
        (vote, f64::from(u8::from(say == Say::Has && s.abs() < 3.0)) * vote)
    };
    let each: Vec<(f64, f64)> = (0..cloud.len()).map(fits).collect();
    let (total, fit) = each.iter().fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
    let share = fit / total;
    let (mut votes, mut before) = (0.0, 0.0);
    let mut best: Option<(f64, usize)> = None;
    for (i, (vote, own)) in each.iter().enumerate() {
        let rest = total - votes;
        // The places are those between which scores are summed, but each point is one.
        if votes >= LEAST_PART.max(ENDS[0] * total) && rest >= LEAST_PART.max((1.0 - ENDS[1]) * total) {
            let apart = before / votes - (fit - before) / rest;
            let square = apart * apart / (share * (1.0 - share) * (1.0 / votes + 1.0 / rest)).max(1e-9);
            if best.is_none_or(|best| 2.0 * square > best.0) {
                best = Some((2.0 * square, i));
            }
        }
        votes += vote;
        before += own;
    }
    best
}

fn suspect_by(solver: &Solver<'_>, cloud: &Cloud, noise: &Noise, state: &State, kernel: Kernel) -> Scored {
    let problem = Problem {
        anchors: &[],
        kernel,
        ..solver.on_field(cloud, noise)
    };
    let n = cloud.len();
    // Sums between each two places, so that each point is looked at once.
    let total: f64 = cloud.votes.iter().sum();
    let mut parts = vec![Sums::default()];
    let mut starts = vec![0];
    let (mut votes, mut next) = (0.0, ENDS[0]);
    for i in 0..n {
        if votes >= next * total && next <= ENDS[1] && votes >= LEAST_PART && total - votes >= LEAST_PART {
            parts.push(Sums::default());
            starts.push(i);
        }
        while votes >= next * total {
            next += STEP;
        }
        let (s, slope, say) = problem.residual(i, state);
        if say == Say::Has
            && let Some(part) = parts.last_mut()
        {
            part.add(&slope, s, cloud.votes[i] * problem.kernel.at(s * s).1);
        }
        votes += cloud.votes[i];
    }
    let mut all = parts.iter().fold(Sums::default(), |all, part| all.with(part));
    for (k, sigma) in [(6, solver.priors.depth_scale), (7, solver.priors.offset_mm)] {
        all.matrix[(k, k)] += if sigma > 0.0 { sigma.powi(-2) } else { 1e12 };
    }
    let mut scored = Scored {
        wide: starts.len() - 1,
        ..Scored::default()
    };
    let Some(inverse) = all.matrix.cholesky().map(|factor| factor.inverse()) else {
        return scored;
    };
    let mut after = all.clone();
    for (part, start) in parts.iter().zip(starts.iter().skip(1)) {
        after = after.without(part);
        let Some(score) = after.score(&all, &inverse).filter(|score| score.is_finite()) else {
            continue;
        };
        scored.places += 1;
        if scored.best.is_none_or(|best| score > best.0) {
            scored.best = Some((score, *start));
        }
    }
    scored
}

/// Sums over some points.
#[derive(Clone, Default)]
struct Sums {
    matrix: Matrix8,
    pull: Vector8,
    /// Of the pulls' squares.
    scatter: Matrix8,
}

impl Sums {
    fn add(&mut self, slope: &Vector8, s: f64, weight: f64) {
        self.matrix.ger(weight, slope, slope, 1.0);
        let pull = slope * (weight * s);
        self.pull += pull;
        self.scatter.ger(1.0, &pull, &pull, 1.0);
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            matrix: self.matrix + other.matrix,
            pull: self.pull + other.pull,
            scatter: self.scatter + other.scatter,
        }
    }

    fn without(&self, other: &Self) -> Self {
        Self {
            matrix: self.matrix - other.matrix,
            pull: self.pull - other.pull,
            scatter: self.scatter - other.scatter,
        }
    }

    /// The square of the pull of these points on a pose of their own, what the common unknowns can answer taken off, in its scatter.
    fn score(&self, all: &Self, inverse: &Matrix8) -> Option<f64> {
        let answer = self.matrix.fixed_rows::<6>(0) * inverse;
        let pull = self.pull.fixed_rows::<6>(0) - answer * all.pull;
        let own = self.scatter.fixed_rows::<6>(0) * answer.transpose();
        let scatter =
            self.scatter.fixed_view::<6, 6>(0, 0) - own - own.transpose() + answer * all.scatter * answer.transpose();
        Some(pull.dot(&scatter.cholesky()?.solve(&pull)))
    }
}
