//! By how much another minimum fits worse.

use crate::points::Cloud;
use crate::solve::{Ended, Exact, NEUTRAL_BEYOND, Say, Solver};

/// What the second of two minima costs more than the first, squares of deviations.
///
/// It is told by the points of which the surface says something in both. By the whole cost a pose gains where it hides what does not fit
/// beyond a border, and one that the points beyond it make dear seems no rival, were it the true one. With more than [`NEUTRAL_BEYOND`] of all
/// beyond it is none by the others alone: some fit anywhere.
pub(super) fn margin(solver: &Solver<'_>, cloud: &Cloud, [best, other]: [&Ended; 2], exact: &Exact<'_>) -> f64 {
    // One after the other: what is kept of each point's surroundings is that of one pose.
    let each = [best, other].map(|ended| {
        let problem = solver.last(cloud, exact, &ended.noise);
        let one = |i: usize| match problem.residual(i, &ended.state) {
            (_, _, Say::Beyond) => None,
            (_, _, Say::FacesAway) => Some(problem.kernel.most()),
            (s, _, Say::Has) => Some(problem.kernel.at(s * s).0),
        };
        (
            (0..cloud.len()).map(one).collect::<Vec<_>>(),
            problem.known_cost(&ended.state),
        )
    });
    let [(first, known), (second, other_known)] = &each;
    let (mut more, mut beyond, mut total) = (other_known - known, 0.0, 0.0);
    for ((first, second), vote) in first.iter().zip(second).zip(&cloud.votes) {
        total += vote;
        match (first, second) {
            (Some(first), Some(second)) => more += vote * (second - first),
            (_, None) => beyond += vote,
            (None, _) => {}
        }
    }
    if beyond > NEUTRAL_BEYOND * total {
        return other.cost - best.cost;
    }
    more
}
