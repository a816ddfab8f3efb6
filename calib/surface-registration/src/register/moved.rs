//! Whether the bone moved while the points were taken: the sweep's two parts as two poses.
//!
//! Points come in the order in which they were taken; no clock is asked. Where the bone moved after some of them, the residuals of the
//! later ones pull at the pose in one direction and those of the earlier ones in the other, whichever minimum the fit of all is in.
//!
//! 1. At each of some places in the order, the pull of the later points on a pose of their own is compared with what it scatters by (a
//!    score test with the points' own scatter, White 1982), with kernels that are not blind to what is far off; and the share of points
//!    that fit before with that after, since a fit leaves the one part out where the bone moved far.
//! 2. Where one of them is more than chance makes of that many places, both parts are fitted as two poses with one depth scale and one
//!    offset, and their difference is compared with its covariance, and the costs with one another.

use geometry::{Frame, Point};
use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6};

use super::parts::{FREE_MM, PointResult, inflation, one};
use super::rows::Rows;
use super::suspect::{LEAST_PART, suspects};
use crate::kernel::Kernel;
use crate::points::Cloud;
use crate::solve::{Exact, Noise, Solver, Stage, State, motion};
use crate::{Priors, SharedError};

/// The two parts of a sweep as two poses: where in the order they differ most, and by what.
#[derive(Debug, Clone, PartialEq)]
pub struct Halves {
    /// Points before the change.
    pub before: usize,
    /// The square of the difference in its covariance, or by how much two poses cost less than one, whichever is less. Of a bone that did
    /// not move about a chi-square of six degrees of freedom, the greatest of some places in the order.
    pub square: f64,
    /// From the second pose to the first, about `centre`: rad, mm.
    motion: Vector6<f64>,
    centre: Vector3<f64>,
}

impl Halves {
    /// By how much the two poses differ at a target, mm.
    pub fn apart_mm<To: Frame>(&self, target: Point<To>) -> f64 {
        let (w, v) = (self.motion.fixed_rows::<3>(0), self.motion.fixed_rows::<3>(3));
        let arm = Vector3::from(target.mm()) - self.centre;
        (w.into_owned().cross(&arm) + v).norm()
    }
}

/// Score from which on the parts are fitted: nearly all runs of a bone that did not move stay below.
const SUSPECT: f64 = 18.0;
type Matrix14 = SMatrix<f64, 14, 14>;

/// Whether it could be looked whether the bone moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OrderCheck {
    /// It was looked at so many places in the order of the points.
    Made {
        /// How many.
        places: usize,
    },
    /// No place has enough points before it and after it: nothing is known.
    TooFew {
        /// All points, such as were taken by a probe held still as one.
        points: f64,
        /// So many are needed on each side of a place.
        least: f64,
    },
    /// Something goes with the order of the points, or could not be computed, and no two poses could be fitted: nothing is known.
    Undecided,
}

impl OrderCheck {
    /// Why nothing is known, in words; `None` where it was looked.
    #[must_use]
    pub fn why_not(&self) -> Option<String> {
        match self {
            Self::Made { .. } => None,
            Self::TooFew { points, least } => Some(format!(
                "whether the bone moved under its marker could not be looked at: {points:.0} points, such as share a place or an image as \
                 one, and {least:.0} are needed before and after a place in their order; take more, or touch the first places again"
            )),
            Self::Undecided => Some(
                "whether the bone moved under its marker could not be decided: no two poses could be fitted to the points before and after; \
                 take more points, or touch the first places again"
                    .to_owned(),
            ),
        }
    }
}

/// The parts that differ most, `None` where nothing goes with the order of the points; and whether it could be looked.
pub(super) fn halves(
    solver: &Solver<'_>,
    cloud: &Cloud,
    shared: Option<&SharedError>,
    noise: &Noise,
    state: &State,
) -> (Option<Halves>, OrderCheck) {
    let suspects = suspects(solver, cloud, noise, state);
    let mut places: Vec<usize> = suspects
        .greatest
        .iter()
        .filter(|(score, _)| *score >= SUSPECT)
        .map(|(_, before)| *before)
        .collect();
    places.dedup();
    let is_suspected = !places.is_empty();
    // Scores of different kinds do not compare; what two poses at their places say does.
    let told = places
        .into_iter()
        .filter_map(|before| at(solver, cloud, shared, state, before));
    let found = told.max_by(|a, b| a.square.total_cmp(&b.square));
    let check = match (&found, suspects.wide, suspects.places) {
        (Some(_), ..) => OrderCheck::Made {
            places: suspects.places.max(1),
        },
        (None, 0, _) => OrderCheck::TooFew {
            points: suspects.points,
            least: LEAST_PART,
        },
        (None, _, places) if is_suspected || places == 0 => OrderCheck::Undecided,
        (None, _, places) => OrderCheck::Made { places },
    };
    (found, check)
}

/// The parts before and after a place as two poses.
fn at(
    solver: &Solver<'_>,
    cloud: &Cloud,
    shared: Option<&SharedError>,
    state: &State,
    before: usize,
) -> Option<Halves> {
    // Held where the fit of all put them: a part has not the depths to tell scale and offset apart.
    let priors = Priors {
        depth_scale: 0.0,
        offset_mm: 0.0,
        ..*solver.priors
    };
    let alone = Solver {
        anchors: &[],
        priors: &priors,
        ..*solver
    };
    let n = cloud.len();
    let first = Part::fitted(&alone, cloud, 0..before, state)?;
    let second = Part::fitted(&alone, cloud, before..n, state)?;
    let (motion, covariance) = difference(solver, (cloud.radius_mm, shared), &first, &second)?;
    let square = motion.dot(&(covariance.cholesky()?.solve(&motion)));
    Some(Halves {
        before,
        square: square.min(first.gained + second.gained),
        motion,
        centre: state.shift,
    })
}

/// One part of the sweep with its own pose.
struct Part {
    state: State,
    rows: Rows,
    each: Vec<PointResult>,
    votes: Vec<f64>,
    /// By how much it costs less than with the pose of all.
    gained: f64,
    /// Number of its first point.
    first: usize,
}

impl Part {
    fn fitted(solver: &Solver<'_>, cloud: &Cloud, range: std::ops::Range<usize>, from: &State) -> Option<Self> {
        // From the pose of all, which lies between the two: wide enough for both, and no wider than a bone moves.
        let chosen: Vec<usize> = range.clone().collect();
        let cloud = cloud.of(&chosen);
        let wide = |m: f64| Stage {
            kernel: Kernel::Wide(m),
            is_facing: true,
            steps: 8,
            settled_mm: 0.05,
        };
        let last = Stage {
            kernel: Kernel::Tukey(solver.end),
            ..wide(3.0)
        };
        let (state, _) = solver.through(&cloud, &solver.blunt(&cloud), *from, &[wide(25.0), wide(8.0)])?;
        let (state, _) = solver.near(&cloud, state, &[wide(3.0), last])?;
        let exact = Exact::new(solver.tree, solver.field, cloud.len());
        let ended = solver.end(&cloud, &exact, state)?;
        let state = ended.state;
        let problem = solver.last(&cloud, &exact, &ended.noise);
        let gained = problem.sum(from).0 - problem.sum(&state).0;
        Some(Self {
            rows: Rows::new(&problem, &state),
            each: (0..cloud.len()).map(|i| one(&problem, i, &state)).collect(),
            votes: cloud.votes.clone(),
            state,
            gained,
            first: range.start,
        })
    }
}

/// From the second pose to the first, to first order as both with one depth scale and one offset, and its covariance.
fn difference(
    solver: &Solver<'_>,
    (radius_mm, shared): (f64, Option<&SharedError>),
    first: &Part,
    second: &Part,
) -> Option<(Vector6<f64>, Matrix6<f64>)> {
    let mut matrix = Matrix14::zeros();
    let mut pull = SVector::<f64, 14>::zeros();
    let mut common = SMatrix::<f64, 14, 6>::zeros();
    for (place, part) in [(0, first), (6, second)] {
        for row in &part.rows.rows {
            let mut slope = SVector::<f64, 14>::zeros();
            slope
                .fixed_rows_mut::<6>(place)
                .copy_from(&row.slope.fixed_rows::<6>(0));
            slope.fixed_rows_mut::<2>(12).copy_from(&row.slope.fixed_rows::<2>(6));
            matrix.ger(row.weight, &slope, &slope, 1.0);
            pull += slope * (row.weight * row.deviations);
            if let Some(SharedError { levers, .. }) = shared {
                let normal = row.slope.fixed_rows::<3>(3).transpose();
                common += slope * (normal * part.state.turn * levers[part.first + row.point]) * row.weight;
            }
        }
    }
    let numbers = [
        (solver.priors.depth_scale, first.state.scale),
        (solver.priors.offset_mm, first.state.offset),
    ];
    for (k, (sigma, value)) in numbers.into_iter().enumerate() {
        let sharp = if sigma > 0.0 { sigma.powi(-2) } else { 1e12 };
        matrix[(12 + k, 12 + k)] += sharp;
        pull[12 + k] += sharp * value;
    }
    // One unit for all: mm at the points, share at a depth of 50 mm.
    let r = 1.0 / radius_mm;
    let mut unit = SVector::<f64, 14>::repeat(1.0);
    (0..3).for_each(|k| (unit[k], unit[6 + k]) = (r, r));
    unit[12] = 0.02;
    let unit = Matrix14::from_diagonal(&unit);
    let eigen = (unit * matrix * unit).symmetric_eigen();
    let values = eigen.eigenvalues.map(|value| 1.0 / value.max(FREE_MM.powi(-2)));
    let inverse =
        unit * (eigen.eigenvectors * Matrix14::from_diagonal(&values) * eigen.eigenvectors.transpose()) * unit;
    let mut minus = SMatrix::<f64, 6, 14>::zeros();
    (0..6).for_each(|k| (minus[(k, k)], minus[(k, 6 + k)]) = (1.0, -1.0));
    let each: Vec<PointResult> = first.each.iter().chain(&second.each).copied().collect();
    let votes: Vec<f64> = first.votes.iter().chain(&second.votes).copied().collect();
    let mut covariance = minus * inverse * minus.transpose() * inflation(solver, &each, &votes, 12.0);
    if let Some(shared) = shared {
        let answer = minus * inverse * common;
        covariance += answer * shared.covariance * answer.transpose();
    }
    Some((motion(&first.state, &second.state) - minus * inverse * pull, covariance))
}
