//! Contact of solids with solids: a barrier between samples of each boundary and the arcs of the others.
//!
//! The energy of a sample that stands for the length `s` of its boundary, at the distance `d < D` of an arc, is
//! `kappa D s B(d / D) / 2`; both solids sample each other. Arcs are the true quadratic ones: the distance `d(a)` is the
//! least over the arc's parameter, and its derivatives are those of the foot that moves with the unknowns.

use std::cell::Cell;
use std::sync::Arc;

use super::ccd::Way;
use super::collision_pairs::Meeting;
use super::contact::Contact;
use super::exact::{Against, Between, Exact};
use super::last_state::LastState;
use super::near::Near;
use super::rows::bend;
use super::samples::Samples;
use super::shape::Shape;
use super::{Continuation, Force, Stage, barrier, ccd_pairs};
use crate::bodies::Bodies;
use crate::solid::Cursor;
use crate::sparse::Triplets;

/// Keeps solids apart.
#[derive(Debug, Clone)]
pub struct SolidBarrier {
    continuation: Continuation,
    /// Units of stress.
    stiffness: f64,
    meeting: Meeting,
    seen: LastState<NearSamples>,
}

/// What was found in a state.
#[derive(Debug)]
struct NearSamples {
    shapes: Vec<Shape>,
    near: Vec<Near>,
}

impl SolidBarrier {
    /// A barrier that begins at the distance `first_width`, and narrows to `last_width` as searches succeed; forces act
    /// over that distance, so it is about the error. `stiffness` (units of stress): 0.1 of the stiffest solid's is good; two of which one is softer push
    /// one another by as much less as that one is.
    pub fn new(first_width: f64, last_width: f64, stiffness: f64) -> Self {
        Self {
            continuation: Continuation::new([first_width, last_width]),
            stiffness,
            meeting: Meeting::default(),
            seen: LastState::default(),
        }
    }

    /// The same, but these solids keep out of themselves too: each sample of their boundary keeps away from all arcs but
    /// its own and the two next to it, from the outside. The width must be less than an arc is long.
    #[must_use]
    pub fn with_own(mut self, bodies: &[usize]) -> Self {
        self.meeting.own = bodies.iter().copied().collect();
        self
    }

    /// The same, but of these pairs of solids alone: all others pass through one another. A solid paired with itself keeps
    /// out of itself, as with [`Self::with_own`].
    #[must_use]
    pub fn among(mut self, pairs: &[[usize; 2]]) -> Self {
        self.meeting = Meeting::among(pairs);
        self
    }

    /// The same, but after the narrowest barrier exact contact takes over, with the barrier's forces to begin with: samples
    /// keep out of the true arcs, and so do closest points of arcs between them.
    #[must_use]
    pub fn then_exact(mut self) -> Self {
        self.continuation.want_exact();
        self
    }

    /// The distance below which solids push each other now.
    pub fn width(&self) -> f64 {
        self.continuation.activation_distance()
    }

    fn samples(&self) -> Samples<'_> {
        Samples {
            meeting: &self.meeting,
            width: self.continuation.activation_distance(),
        }
    }

    /// Every sample within the barrier in a state.
    fn near(&self, bodies: &Bodies, a: &[f64]) -> Arc<NearSamples> {
        self.seen.at(a, || {
            let (shapes, mut near) = (Self::shapes(bodies, a), Vec::new());
            let within = Cell::new(self.width());
            self.samples().visit(bodies, &shapes, &within, &mut |n| near.push(n));
            NearSamples { shapes, near }
        })
    }

    /// Energy of a pair and its two derivatives by the distance.
    fn energy_of(&self, bodies: &Bodies, near: &Near) -> Option<[f64; 3]> {
        let [own, other] = near.on.map(|body| bodies.relative_stiffness(body));
        // Half, as each of two solids samples the other. Stress times length times width: an energy by depth.
        let scale = 0.5 * self.stiffness * own.min(other) * near.length * self.continuation.activation_distance();
        let [b, first, second] = barrier(near.at.distance / self.continuation.activation_distance())?;
        Some([
            scale * b,
            scale * first / self.continuation.activation_distance(),
            scale * second / (self.continuation.activation_distance() * self.continuation.activation_distance()),
        ])
    }

    fn shapes(bodies: &Bodies, a: &[f64]) -> Vec<Shape> {
        (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect()
    }
}

impl Contact for SolidBarrier {
    const STAGE_WITHOUT_EXACT: Stage = Stage::FinalBarrier;

    fn continuation(&self) -> &Continuation {
        &self.continuation
    }

    fn continuation_mut(&mut self) -> &mut Continuation {
        // A narrower barrier sees other samples in the same state.
        self.seen.forget();
        &mut self.continuation
    }

    fn soft_energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        let seen = self.near(bodies, a);
        seen.near
            .iter()
            .map(|near| Some(self.energy_of(bodies, near)?[0]))
            .sum()
    }

    fn soft_gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let mut sum = 0.0;
        for near in &self.near(bodies, a).near {
            let [energy, first, _] = self.energy_of(bodies, near)?;
            // At the foot the distance does not change along the arc: its motion has no part in the first derivative.
            let pull = near.direction() * first;
            for row in near.rows(bodies, a).0.iter() {
                gradient[row.unknown] += pull.dot(&row.by);
            }
            sum += energy;
        }
        Some(sum)
    }

    fn soft_hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        let seen = self.near(bodies, a);
        for near in &seen.near {
            let [_, first, second] = self.energy_of(bodies, near)?;
            let (e, rows) = (near.direction(), near.rows(bodies, a));
            let arc = &seen.shapes[near.on[1]].arcs[near.foot.arc];
            // The slope is negative, and a distance mostly bends upwards: this part can make the matrix indefinite.
            let bent = if convex { 0.0 } else { first };
            near.add_second(&rows, arc, [bent, second], sink);
            if !convex {
                bend(bodies, near.on[0], &near.sample, a, e * first, sink);
                bend(bodies, near.on[1], &near.foot, a, e * -first, sink);
            }
        }
        Some(())
    }

    fn soft_reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let seen = self.near(bodies, a);
        let distances = seen.near.iter().map(|n| n.at.distance);
        let way = Way {
            bodies,
            a,
            step,
            start: &seen.shapes,
            // A sample that is not among the near ones is at least the width away.
            least: distances.fold(self.width(), f64::min),
        };
        ccd_pairs::reach(&way, self.samples(), 0.0)
    }

    fn soft_forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        let seen = self.near(bodies, a);
        let each = seen.near.iter().filter_map(|near| {
            let force = near.direction() * -self.energy_of(bodies, near)?[1];
            let (place, gap) = (seen.shapes[near.on[0]].place(&near.sample), near.at.distance);
            let point = place + bodies.origin();
            let own = Force {
                body: near.on[0],
                point,
                force,
                gap,
            };
            let other = Force {
                body: near.on[1],
                point: point - near.at.offset,
                force: -force,
                gap,
            };
            Some([own, other])
        });
        each.flatten().collect()
    }

    /// Every sample nearer than twice the width becomes a row.
    fn hand_over(&self, bodies: &Bodies, a: &[f64]) -> Exact {
        let between = Between::Solids {
            width: self.continuation.activation_distance(),
            meeting: self.meeting.clone(),
        };
        let mut rows: Vec<(usize, Cursor, Against, f64)> = Vec::new();
        let reach = Cell::new(between.depth());
        self.samples()
            .visit(bodies, &Self::shapes(bodies, a), &reach, &mut |near| {
                // Between one width and two the barrier has no slope: such a row begins without a force.
                let force = self.energy_of(bodies, &near).map_or(0.0, |e| -e[1]);
                let [body, other] = near.on;
                let foot = near.foot;
                rows.push((body, near.sample, Against::Arc { other, foot }, force));
            });
        Exact::new(between, bodies, a, rows.into_iter())
    }
}
