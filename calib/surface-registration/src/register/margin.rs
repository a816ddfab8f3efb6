//! By how much another minimum fits worse.

use crate::points::Cloud;
use crate::solve::{Ended, Exact, NEUTRAL_BEYOND, Say, Solver};

/// What each point costs at a pose, squares of deviations; `None` for one beyond an open border.
#[derive(Debug, Clone)]
pub(crate) struct Costs {
    each: Vec<Option<f64>>,
    votes: Vec<f64>,
    /// Of what is known before.
    known: f64,
    /// Of all, points beyond a border at the price of the others.
    all: f64,
}

impl Costs {
    /// Of a fit that ended. What is kept of each point's surroundings in `exact` is that of one pose: those of another are asked for next.
    pub(super) fn of(solver: &Solver<'_>, cloud: &Cloud, ended: &Ended, exact: &Exact<'_>) -> Self {
        let problem = solver.last(cloud, exact, &ended.noise);
        let one = |i: usize| match problem.residual(i, &ended.state) {
            (_, _, Say::Beyond) => None,
            (_, _, Say::FacesAway) => Some(problem.kernel.most()),
            (s, _, Say::Has) => Some(problem.kernel.at(s * s).0),
        };
        Self {
            each: (0..cloud.len()).map(one).collect(),
            votes: cloud.votes.clone(),
            known: problem.known_cost(&ended.state),
            all: ended.cost,
        }
    }

    /// What another pose of the same points, or of their mirror images, costs more, squares of deviations.
    ///
    /// It is told by the points of which the surface says something in both. By the whole cost a pose gains where it hides what does not fit
    /// beyond a border, and one that the points beyond it make dear seems no rival, were it the true one. With more than [`NEUTRAL_BEYOND`]
    /// of all beyond it is none by the others alone: some fit anywhere. How much a point counts is what it counts here: mirrored points lie
    /// nearer to one another, or further apart.
    pub(super) fn margin(&self, other: &Self) -> f64 {
        let (mut more, mut beyond, mut total) = (other.known - self.known, 0.0, 0.0);
        for ((first, second), vote) in self.each.iter().zip(&other.each).zip(&self.votes) {
            total += vote;
            match (first, second) {
                (Some(first), Some(second)) => more += vote * (second - first),
                (_, None) => beyond += vote,
                (None, _) => {}
            }
        }
        if beyond > NEUTRAL_BEYOND * total {
            return other.all - self.all;
        }
        more
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(each: &[Option<f64>]) -> Costs {
        let known: Vec<f64> = each.iter().copied().flatten().collect();
        let sum: f64 = known.iter().sum();
        Costs {
            each: each.to_vec(),
            votes: vec![1.0; each.len()],
            known: 0.0,
            // Each point beyond at the price of the others: what is seen below is with less than half of them there.
            all: sum * each.len() as f64 / known.len() as f64,
        }
    }

    fn joined(parts: &[(usize, Option<f64>)]) -> Costs {
        let each: Vec<Option<f64>> = parts.iter().flat_map(|(count, cost)| vec![*cost; *count]).collect();
        costs(&each)
    }

    /// Of 100 points a rival hides 20 that do not fit beyond a border, and is worse by all others.
    #[test]
    fn what_is_hidden_beyond_a_border_is_no_gain() {
        let found = joined(&[(80, Some(1.0)), (20, Some(6.0))]);
        let rival = joined(&[(80, Some(1.4)), (20, None)]);
        assert!(rival.all < found.all);
        // 80 times 0.4, to rounding.
        assert!((found.margin(&rival) - 32.0).abs() < 1e-9);
    }

    /// And one is no worse by the points of both, which what lies beyond a border there makes dear.
    #[test]
    fn what_is_dear_beyond_a_border_is_a_rival_all_the_same() {
        let found = joined(&[(60, Some(1.5)), (40, Some(0.5))]);
        let rival = joined(&[(60, Some(1.5)), (40, None)]);
        assert!(rival.all - found.all > 15.0);
        assert!(found.margin(&rival).abs() < 1e-9);
    }

    /// A pose with most of the points beyond fits by the rest wherever that is.
    #[test]
    fn a_few_points_that_fit_are_no_rival() {
        let found = joined(&[(100, Some(1.0))]);
        let rival = Costs {
            all: 500.0,
            ..joined(&[(49, Some(0.2)), (51, None)])
        };
        assert!((found.margin(&rival) - 400.0).abs() < 1e-9);
    }
}
