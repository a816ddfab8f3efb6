//! The stages of a fit: from a kernel that feels everything to one that forgets gross errors, from the field to the surface itself.

use fit::{Damping, Limits, least_squares};
use nalgebra::Vector3;

use super::problem::MOST_BEND_MM;
use super::{Anchor, Distances, Exact, Priors, Problem, Say, State, apart_mm};
use crate::points::Cloud;
use crate::tree::Tree;
use crate::{Field, Kernel};

/// What fits of one search have in common.
#[derive(Clone, Copy)]
pub(crate) struct Solver<'a> {
    pub(crate) tree: &'a Tree,
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
    /// What the noise of the points was taken for.
    pub(crate) noise: Noise,
}

/// Rounds of the end: in each one the deviations are those of the pose before.
const ROUNDS: usize = 8;
/// Rounds after which a point that was beyond an open border stays there: one that says nothing does no harm, and rounds between which points
/// go to and fro have no end. (One that goes beyond may always: were it held, it would draw the fit back under the border.)
const FREE_ROUNDS: usize = 3;
/// Where a second round and later ones moved the points by less, mm, deviations are halfway between those of both poses: with those of the last
/// one alone some fits go to and fro for ever between two poses that are up to 0.35 mm apart at the points. What moves further goes somewhere,
/// and deviations of where it was would flatter its cost.
const TO_AND_FRO_MM: f64 = 0.5;
/// Steps of one round.
const ROUND_STEPS: usize = 8;
/// A step that ends a round, mm.
const SETTLED_MM: f64 = 0.02;
/// A round that moved the points by less ends the fit, mm: deviations and bends that are those of a pose so far off change the minimum by
/// a tenth of it, some hundredths of the least error that is promised.
const STILL_MM: f64 = 0.06;

/// Over so much, mm, a surface's bend over the noise does not change: the cells that it is taken from are twenty times as large.
const SAME_BEND_MM: f64 = 0.1;

/// What a last round may have moved the points by, mm: some fits sway for ever, as a point at the kernel's edge or on the ridge between two
/// facets changes sides, and by less than a third of the least error that is promised it is no matter.
const SWAYING_MM: f64 = 0.1;

impl Solver<'_> {
    /// One over each point's deviation, of the mean of its variances over the axes.
    pub(crate) fn blunt(&self, cloud: &Cloud) -> Vec<f64> {
        let bone = self.priors.bone_mm;
        cloud.sigmas.iter().map(|s| 1.0 / s.hypot(bone)).collect()
    }

    /// To the minimum on the field, with each point's deviation along its normal.
    pub(crate) fn near(&self, cloud: &Cloud, start: State, stages: &[Stage; 2]) -> Option<(State, f64)> {
        let (state, _) = self.through(cloud, &self.blunt(cloud), start, &stages[..1])?;
        let noise = self.noise(cloud, self.field, &state, |_| 0.0);
        let problem = Problem {
            facing: Some(self.facing),
            kernel: stages[1].kernel,
            settled_mm: stages[1].settled_mm,
            is_dear: true,
            ..self.on_field(cloud, &noise)
        };
        let ended = least_squares(&problem, state, Damping::GAUSS_NEWTON, Limits::tries(stages[1].steps))?;
        Some((ended.state, ended.cost))
    }

    /// A problem on the field with points' own deviations.
    pub(crate) fn on_field<'b>(&'b self, cloud: &'b Cloud, noise: &'b Noise) -> Problem<'b, Field> {
        Problem {
            cloud,
            distances: self.field,
            anchors: self.anchors,
            priors: self.priors,
            kernel: Kernel::Tukey(self.end),
            facing: Some(self.facing),
            sharp: &noise.sharp,
            bends: &noise.bends,
            beyond: &[],
            settled_mm: 0.0,
            is_dear: false,
        }
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
                beyond: &[],
                settled_mm: stage.settled_mm,
                is_dear: false,
            };
            let ended = least_squares(&problem, now.0, Damping::GAUSS_NEWTON, Limits::tries(stage.steps))?;
            now = (ended.state, ended.cost);
        }
        Some(now)
    }

    /// To the minimum, on the surface itself, with each point's deviation along its normal.
    pub(crate) fn end(&self, cloud: &Cloud, exact: &Exact<'_>, start: State) -> Option<Ended> {
        let mut noise = self.exact_noise(cloud, exact, &start);
        // Where the bends were looked at.
        let mut bent = start;
        let mut now = Ended {
            state: start,
            cost: f64::INFINITY,
            steps: 0,
            is_settled: false,
            noise: Noise::default(),
        };
        let mut moved = f64::INFINITY;
        for round in 0..ROUNDS {
            if round > 0 {
                let before = noise.clone();
                if apart_mm(&now.state, &bent, cloud.radius_mm) < SAME_BEND_MM {
                    self.sharpen(cloud, exact, &now.state, &mut noise);
                } else {
                    (noise, bent) = (self.exact_noise(cloud, exact, &now.state), now.state);
                }
                if round > 1 && moved < TO_AND_FRO_MM {
                    noise.halfway_to(&before);
                }
                noise.beyond = before.beyond;
                if round >= FREE_ROUNDS {
                    noise.beyond = self.sides(cloud, exact, &noise, &now.state);
                }
            }
            let problem = self.last(cloud, exact, &noise);
            let ended = least_squares(&problem, now.state, Damping::GAUSS_NEWTON, Limits::tries(ROUND_STEPS))?;
            // The deviations change the minimum by a share of what the last round moved: once that is little nothing is left to change.
            moved = apart_mm(&ended.state, &now.state, cloud.radius_mm);
            (now.state, now.cost) = (ended.state, ended.cost);
            (now.steps, now.is_settled) = (now.steps + ended.steps, moved < SWAYING_MM);
            if moved < STILL_MM {
                break;
            }
        }
        Some(Ended { noise, ..now })
    }

    /// Which points lie beyond an open border, those that are held there among them.
    fn sides(&self, cloud: &Cloud, exact: &Exact<'_>, noise: &Noise, state: &State) -> Vec<bool> {
        if self.field.is_closed() {
            return Vec::new();
        }
        let problem = self.last(cloud, exact, noise);
        (0..cloud.len())
            .map(|i| problem.residual(i, state).2 == Say::Beyond)
            .collect()
    }

    /// The problem of the end.
    pub(crate) fn last<'b>(&'b self, cloud: &'b Cloud, exact: &'b Exact<'_>, noise: &'b Noise) -> Problem<'b, Exact<'b>>
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
            sharp: &noise.sharp,
            bends: &noise.bends,
            beyond: &noise.beyond,
            settled_mm: SETTLED_MM,
            is_dear: true,
        }
    }

    /// What each point's noise does to its distance from the surface where it is.
    ///
    /// Beside the deviation along the normal, noise along a surface that curves away carries points off it to one side: of a ridge of
    /// 8 mm radius and 1.5 mm of noise along it by 1.5^2 / (2 x 8) = 0.14 mm on average, which no number of points makes less, and by as
    /// much times the root of two in deviation. Of a quadratic surface both follow from the second differences over the axes of the
    /// noise at the root of three deviations, `h = 3 sigma^2 d''`: the mean is the sum of `h / 6`, the variance that of `h^2 / 18`. They
    /// are taken from the field, whose cells are of the size of the noise.
    pub(crate) fn exact_noise(&self, cloud: &Cloud, exact: &Exact<'_>, state: &State) -> Noise {
        self.noise(cloud, exact, state, |i| exact.smooth(i).map_or(0.0, |(_, bulge)| bulge))
    }

    /// Takes the deviations along the normals at another state, the bends staying what they were.
    fn sharpen(&self, cloud: &Cloud, exact: &Exact<'_>, state: &State, noise: &mut Noise) {
        for i in 0..cloud.len() {
            let arm = state.turn * (cloud.places[i] - cloud.deep[i] * state.scale);
            let (_, n, _) = exact.look(i, &(arm + state.shift), 0.0);
            noise.sharp[i] = 1.0 / (self.along(cloud, i, state, &n) + noise.spread[i]).sqrt();
        }
    }

    /// Variance of a point along a normal, the bone's own with it, mm^2.
    fn along(&self, cloud: &Cloud, i: usize, state: &State, n: &Vector3<f64>) -> f64 {
        // The field's gradient is not of length 1.
        let own: Vector3<f64> = state.turn.tr_mul(n) / n.norm().max(1e-3);
        own.dot(&(cloud.covariances[i] * own)) + self.priors.bone_mm * self.priors.bone_mm
    }

    /// The same by any distances; `bulge` of the facet nearest to a point, mm.
    fn noise(&self, cloud: &Cloud, distances: &impl Distances, state: &State, bulge: impl Fn(usize) -> f64) -> Noise {
        let mut noise = Noise::default();
        for i in 0..cloud.len() {
            let arm = state.turn * (cloud.places[i] - cloud.deep[i] * state.scale);
            let p = arm + state.shift;
            let (d, n, _) = distances.look(i, &p, 0.0);
            let (mut spread, mut bend) = (0.0, 0.0);
            // Further off a point has no say, whatever its noise.
            if d.abs() < FAR_DEVIATIONS * (cloud.sigmas[i] + self.priors.bone_mm) + FAR_MM {
                let middle = self.field.look(&p).0;
                let root = state.turn * cloud.roots[i];
                let mut squares = 0.0;
                for axis in 0..3 {
                    let step = root.column(axis) * 3.0_f64.sqrt();
                    let h = self.field.look(&(p + step)).0 + self.field.look(&(p - step)).0 - 2.0 * middle;
                    bend += h / 6.0;
                    squares += h * h / 18.0;
                }
                // Of a bulge between 0 and so much, half of it.
                spread = squares.min(MOST_BEND_MM * MOST_BEND_MM) + (0.5 * bulge(i)).powi(2);
            }
            noise
                .sharp
                .push(1.0 / (self.along(cloud, i, state, &n) + spread).sqrt());
            noise.spread.push(spread);
            noise.bends.push(bend.clamp(-MOST_BEND_MM, MOST_BEND_MM));
        }
        noise
    }
}

/// How far off points may still have a say: deviations at the largest, twice the greatest kernel that is common, and mm of offset.
const FAR_DEVIATIONS: f64 = 10.0;
const FAR_MM: f64 = 2.0;

/// What the noise of points does to their distances.
#[derive(Debug, Clone, Default)]
pub(crate) struct Noise {
    /// One over each point's deviation along the normal of the surface at it, 1/mm.
    pub(crate) sharp: Vec<f64>,
    /// By how much each point lies outside of the surface on average because the surface bends, mm.
    pub(crate) bends: Vec<f64>,
    /// Which points are taken for ones beyond an open border whatever their nearest place says; empty for none.
    pub(crate) beyond: Vec<bool>,
    /// Variance that bends and facets add to that along the normal, mm^2.
    spread: Vec<f64>,
}

impl Noise {
    /// Takes variances and bends halfway to those of another pose: what both agree in stays.
    fn halfway_to(&mut self, other: &Self) {
        for i in 0..self.sharp.len() {
            let variance = 0.5 * (self.sharp[i].powi(-2) + other.sharp[i].powi(-2));
            self.sharp[i] = 1.0 / variance.sqrt();
            self.bends[i] = 0.5 * (self.bends[i] + other.bends[i]);
            self.spread[i] = 0.5 * (self.spread[i] + other.spread[i]);
        }
    }
}
