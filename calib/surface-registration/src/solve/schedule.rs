//! The stages of a fit: from a kernel that feels everything to one that forgets gross errors, from the field to the surface itself.

use fit::{Damping, Limits, least_squares};
use geometry::Frame;
use nalgebra::Vector3;

use super::problem::{Exact, MOST_BEND_MM};
use super::{Anchor, Distances, Priors, Problem, State, apart_mm};
use crate::points::Cloud;
use crate::{Field, Kernel, Surface};

/// What fits of one search have in common.
#[derive(Clone, Copy)]
pub(crate) struct Solver<'a, F> {
    pub(crate) surface: &'a Surface<F>,
    pub(crate) field: &'a Field,
    pub(crate) anchors: &'a [Anchor],
    pub(crate) priors: &'a Priors,
    /// Tukey's constant, deviations.
    pub(crate) end: f64,
    /// Cosine between beam and outward normal from which on a point faces away.
    pub(crate) facing: f64,
}

/// A stage on the field.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stage {
    pub(crate) kernel: Kernel,
    pub(crate) is_facing: bool,
    /// Steps at most.
    pub(crate) steps: usize,
    pub(crate) settled_mm: f64,
}

/// Where a fit ended.
#[derive(Debug, Clone)]
pub(crate) struct Ended {
    pub(crate) state: State,
    pub(crate) cost: f64,
    pub(crate) steps: usize,
    pub(crate) is_settled: bool,
}

/// Rounds of the end: in each one the deviations are those of the pose before.
const ROUNDS: usize = 6;
/// Steps of one round.
const ROUND_STEPS: usize = 20;
/// A step that ends a round, mm.
const SETTLED_MM: f64 = 8e-3;
/// A round that moved the points by less ends the fit, mm: a tenth of the least error that is promised of the best sweeps, and more than
/// by what a fit goes to and fro between two facets of the surface.
const STILL_MM: f64 = 0.02;

/// What a last round may have moved the points by, mm: some fits sway for ever, as a point at the kernel's edge or on the ridge between two
/// facets changes sides, and by less than a third of the least error that is promised it is no matter.
const SWAYING_MM: f64 = 0.1;

impl<F: Frame> Solver<'_, F> {
    /// One over each point's deviation, of the mean of its variances over the axes.
    pub(crate) fn blunt(&self, cloud: &Cloud) -> Vec<f64> {
        let bone = self.priors.bone_mm;
        cloud.sigmas.iter().map(|s| 1.0 / s.hypot(bone)).collect()
    }

    /// Through stages on the field.
    pub(crate) fn through(&self, cloud: &Cloud, sharp: &[f64], start: State, stages: &[Stage]) -> Option<(State, f64)> {
        let mut now = (start, f64::INFINITY);
        for stage in stages {
            let problem = Problem {
                cloud,
                distances: self.field,
                anchors: self.anchors,
                priors: self.priors,
                kernel: stage.kernel,
                facing: stage.is_facing.then_some(self.facing),
                sharp,
                bends: &[],
                settled_mm: stage.settled_mm,
            };
            let ended = least_squares(&problem, now.0, Damping::GAUSS_NEWTON, Limits::tries(stage.steps))?;
            now = (ended.state, ended.cost);
        }
        Some(now)
    }

    /// To the minimum, on the surface itself, with each point's deviation along its normal.
    pub(crate) fn end(&self, cloud: &Cloud, exact: &Exact<'_, F>, start: State) -> Option<Ended> {
        let mut now = Ended {
            state: start,
            cost: f64::INFINITY,
            steps: 0,
            is_settled: false,
        };
        for _ in 0..ROUNDS {
            let sharp = self.sharp(cloud, exact, &now.state);
            let bends = self.bends(cloud, &now.state);
            let problem = self.last(cloud, exact, &sharp, &bends);
            let ended = least_squares(&problem, now.state, Damping::GAUSS_NEWTON, Limits::tries(ROUND_STEPS))?;
            // The deviations change the minimum by a share of what the last round moved: once that is little nothing is left to change.
            let moved = apart_mm(&ended.state, &now.state, cloud.radius_mm);
            now = Ended {
                state: ended.state,
                cost: ended.cost,
                steps: now.steps + ended.steps,
                is_settled: moved < SWAYING_MM,
            };
            if moved < STILL_MM {
                break;
            }
        }
        Some(now)
    }

    /// The problem of the end.
    pub(crate) fn last<'b>(
        &'b self,
        cloud: &'b Cloud,
        exact: &'b Exact<'_, F>,
        sharp: &'b [f64],
        bends: &'b [f64],
    ) -> Problem<'b, Exact<'b, F>>
    where
        Self: 'b,
    {
        Problem {
            cloud,
            distances: exact,
            anchors: self.anchors,
            priors: self.priors,
            kernel: Kernel::Tukey(self.end),
            facing: Some(self.facing),
            sharp,
            bends,
            settled_mm: SETTLED_MM,
        }
    }

    /// One over each point's deviation along the normal of the surface at it.
    pub(crate) fn sharp(&self, cloud: &Cloud, exact: &Exact<'_, F>, state: &State) -> Vec<f64> {
        let bone = self.priors.bone_mm * self.priors.bone_mm;
        let one = |i: usize| {
            let arm = state.turn * (cloud.places[i] - cloud.deep[i] * state.scale);
            let (_, n, _) = exact.look(i, &(arm + state.shift), 0.0);
            let own: Vector3<f64> = state.turn.tr_mul(&n);
            1.0 / (own.dot(&(cloud.covariances[i] * own)) + bone).sqrt()
        };
        (0..cloud.len()).map(one).collect()
    }

    /// By how much each point lies outside of the surface on average because the surface bends, mm.
    ///
    /// Noise along a surface that curves away carries points off it to one side: of a ridge of 8 mm radius and 1.5 mm of noise along it
    /// by 1.5^2 / (2 x 8) = 0.14 mm, which no number of points makes less. The mean over the noise is that over six points at the root of
    /// three deviations along its axes (exact for a quadratic surface), taken from the field, whose cells are of the size of the noise.
    pub(crate) fn bends(&self, cloud: &Cloud, state: &State) -> Vec<f64> {
        let one = |i: usize| {
            let arm = state.turn * (cloud.places[i] - cloud.deep[i] * state.scale);
            let p = arm + state.shift;
            let middle = self.field.look(&p).0;
            let root = state.turn * cloud.roots[i];
            let mut sum = 0.0;
            for axis in 0..3 {
                let step = root.column(axis) * 3.0_f64.sqrt();
                sum += self.field.look(&(p + step)).0 + self.field.look(&(p - step)).0 - 2.0 * middle;
            }
            (sum / 6.0).clamp(-MOST_BEND_MM, MOST_BEND_MM)
        };
        (0..cloud.len()).map(one).collect()
    }
}
