//! Each point's part in a fit, and what all of them say of its scatter.

use crate::kernel::tukey_variance;
use crate::solve::{Exact, Problem, Say, Solver, State};

/// What became of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// It has a say.
    Kept,
    /// Left out: it lies outside of the bone, where soft tissue echoes.
    InFront,
    /// Left out: it lies inside of the bone.
    Behind,
    /// Left out: its beam comes from inside the bone.
    FacesAway,
    /// Left out: the bone nearest to it is an open border of the surface, beyond which nothing is known.
    Beyond,
}

/// One point's part in a registration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointResult {
    /// Its distance to the surface with the offset taken off, mm: above 0 outside.
    pub residual_mm: f64,
    /// The same in its own deviations along the normal.
    pub deviations: f64,
    /// What it counts, 0 to 1.
    pub weight: f64,
    /// What became of it.
    pub class: Class,
}

/// Residuals beyond so many deviations are not those of the noise.
const KEPT: f64 = 3.0;
/// The mean square of a normal residual that is within three deviations.
const MEAN_SQUARE: f64 = 0.973_34;
/// Deviation, mm, of what nothing holds.
pub(crate) const FREE_MM: f64 = 1000.0;

/// The part of a point.
pub(super) fn one(problem: &Problem<'_, Exact<'_>>, i: usize, state: &State) -> PointResult {
    let (s, _, say) = problem.residual(i, state);
    let (_, weight) = problem.kernel.at(s * s);
    let class = match say {
        Say::FacesAway => Class::FacesAway,
        Say::Beyond => Class::Beyond,
        Say::Has if weight > 0.0 => Class::Kept,
        Say::Has if s > 0.0 => Class::InFront,
        Say::Has => Class::Behind,
    };
    PointResult {
        residual_mm: s / problem.sharp[i],
        deviations: s,
        weight: if say == Say::Has {
            weight * problem.cloud.votes[i]
        } else {
            0.0
        },
        class,
    }
}

/// By how much the covariance exceeds the inverse of the weighted normal equations.
pub(super) fn inflation(solver: &Solver<'_>, each: &[PointResult], votes: &[f64], fitted: f64) -> f64 {
    let Kept { ratio, sigma, .. } = kept(each, votes, fitted);
    // Each estimate but for one deviation of its own: the greatest of some numbers that scatter about 1 would be above it on average, and
    // with 100 points promise an error that is too large by 4 %.
    let least = (1.0 - sigma).max(0.5);
    let told = tukey_variance(solver.end) * (ratio * least).max(1.0).powi(2);
    told.max(scattered(each, votes, solver.end, fitted) * (1.0 - 2.0 * sigma).max(0.25))
}

/// What the residuals within three deviations say of the noise.
pub(super) struct Kept {
    pub(super) count: f64,
    pub(super) ratio: f64,
    pub(super) sigma: f64,
}

pub(super) fn kept(each: &[PointResult], votes: &[f64], fitted: f64) -> Kept {
    let (mut count, mut squares) = (0.0, 0.0);
    for (point, vote) in each.iter().zip(votes) {
        if point.class == Class::Kept && point.deviations.abs() <= KEPT {
            count += vote;
            squares += vote * point.deviations * point.deviations;
        }
    }
    let freedom = MEAN_SQUARE * count - fitted;
    // Without anything left over nothing is known of the noise.
    let (ratio, sigma) = if freedom > 0.5 {
        ((squares / freedom).sqrt(), (0.5 / freedom).sqrt())
    } else {
        (f64::INFINITY, f64::INFINITY)
    };
    Kept { count, ratio, sigma }
}

/// By how much the variance exceeds the inverse of the weighted normal equations, by the residuals themselves (Huber 1981, section 6.6):
/// gross errors that lie near the surface have a say, and scatter the result more than the noise that was told does.
fn scattered(each: &[PointResult], votes: &[f64], end: f64, fitted: f64) -> f64 {
    let (mut count, mut squares, mut slope, mut weights) = (0.0, 0.0, 0.0, 0.0);
    for (point, vote) in each.iter().zip(votes).filter(|(point, _)| point.class == Class::Kept) {
        let share = (point.deviations / end).powi(2);
        let left = (1.0 - share).max(0.0);
        count += vote;
        squares += vote * (left * left * point.deviations).powi(2);
        slope += vote * (left * left - 4.0 * left * share);
        weights += vote * left * left;
    }
    let freedom = count - fitted;
    if freedom <= 0.5 || slope <= 0.0 {
        // The count of points refuses this; as the error of nothing it is large.
        return FREE_MM;
    }
    count / freedom * squares * weights / (slope * slope)
}
