//! Contact of solids with solids: a barrier between samples of each boundary and the arcs of the others.
//!
//! The energy of a sample that stands for the length `s` of its boundary, at the distance `d < D` of an arc, is
//! `kappa D s B(d / D) / 2`; both solids sample each other. Arcs are the true quadratic ones: the distance `d(a)` is the
//! least over the arc's parameter, and its derivatives are those of the foot that moves with the unknowns.

use std::cell::{Cell, RefCell};

use super::advance::Way;
use super::apart::Apart;
use super::exact::{Against, Between, Exact};
use super::meeting::Meeting;
use super::near::Near;
use super::rows::bend;
use super::samples::Samples;
use super::shape::Shape;
use super::stage::Stage;
use super::{Active, Change, Force, Term, advance, barrier};
use crate::bodies::Bodies;
use crate::solid::Cursor;
use crate::sparse::Triplets;

/// Keeps solids apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairs {
    stage: Stage,
    /// Units of stress.
    stiffness: f64,
    meeting: Meeting,
    seen: Memory,
}

/// What was found in the last state that was asked for: no part of what the term is.
#[derive(Debug, Default)]
struct Memory(RefCell<Option<Seen>>);

#[derive(Debug)]
struct Seen {
    a: Vec<f64>,
    width: f64,
    shapes: Vec<Shape>,
    near: Vec<Near>,
}

impl Clone for Memory {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Memory {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Pairs {
    /// A barrier that begins at the distance `first_width`, and narrows to `last_width` as searches succeed; forces act
    /// over that distance, so it is about the error. `stiffness` (units of stress): 0.1 of the stiffest solid's is good; two of which one is softer push
    /// one another by as much less as that one is.
    pub fn new(first_width: f64, last_width: f64, stiffness: f64) -> Self {
        Self {
            stage: Stage::new([first_width, last_width]),
            stiffness,
            meeting: Meeting::default(),
            seen: Memory::default(),
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
    pub fn polished(mut self) -> Self {
        self.stage.polish();
        self
    }

    /// Hands the forces over to the exact contact: every sample nearer than twice the width becomes a row.
    fn hand_over(&self, bodies: &Bodies, a: &[f64]) -> Exact {
        let between = Between::Solids {
            width: self.stage.width,
            meeting: self.meeting.clone(),
        };
        let mut rows: Vec<(usize, Cursor, Against, f64)> = Vec::new();
        let reach = Cell::new(between.depth());
        self.samples()
            .visit(bodies, &Self::shapes(bodies, a), &reach, &mut |near| {
                let force = self.energy_of(bodies, &near).map_or(0.0, |e| -e[1]);
                let [body, other] = near.on;
                let foot = near.foot;
                rows.push((body, near.sample, Against::Arc { other, foot }, force));
            });
        Exact::new(between, bodies, a, rows.into_iter())
    }

    /// The distance below which solids push each other now.
    pub fn width(&self) -> f64 {
        self.stage.width
    }

    fn samples(&self) -> Samples<'_> {
        Samples {
            meeting: &self.meeting,
            width: self.stage.width,
        }
    }

    /// Every sample within the barrier in a state, found once: energy, gradient and second derivatives ask for the same
    /// state one after the other.
    fn near<T>(&self, bodies: &Bodies, a: &[f64], look: impl FnOnce(&[Shape], &[Near]) -> T) -> T {
        let mut seen = self.seen.0.borrow_mut();
        if !seen.as_ref().is_some_and(|s| s.width == self.stage.width && s.a == a) {
            let (shapes, mut near) = (Self::shapes(bodies, a), Vec::new());
            self.samples()
                .visit(bodies, &shapes, &Cell::new(self.stage.width), &mut |n| near.push(n));
            *seen = Some(Seen {
                a: a.to_vec(),
                width: self.stage.width,
                shapes,
                near,
            });
        }
        match seen.as_ref() {
            Some(seen) => look(&seen.shapes, &seen.near),
            None => look(&[], &[]),
        }
    }

    /// Energy of a pair and its two derivatives by the distance.
    fn energy_of(&self, bodies: &Bodies, near: &Near) -> Option<[f64; 3]> {
        let [own, other] = near.on.map(|body| bodies.relative_stiffness(body));
        let scale = 0.5 * self.stiffness * own.min(other) * near.length * self.stage.width;
        let [b, first, second] = barrier(near.at.distance / self.stage.width)?;
        Some([
            scale * b,
            scale * first / self.stage.width,
            scale * second / (self.stage.width * self.stage.width),
        ])
    }

    fn shapes(bodies: &Bodies, a: &[f64]) -> Vec<Shape> {
        (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect()
    }
}

impl Term for Pairs {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        if let Some(exact) = &self.stage.exact {
            return exact.energy(bodies, a);
        }
        self.near(bodies, a, |_, near| {
            near.iter().map(|near| Some(self.energy_of(bodies, near)?[0])).sum()
        })
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        if let Some(exact) = &self.stage.exact {
            return exact.gradient(bodies, a, gradient);
        }
        self.near(bodies, a, |_, near| {
            let mut sum = 0.0;
            for near in near {
                let [energy, first, _] = self.energy_of(bodies, near)?;
                let pull = near.direction() * first;
                for row in near.rows(bodies, a).0.iter() {
                    gradient[row.unknown] += pull.dot(&row.by);
                }
                sum += energy;
            }
            Some(sum)
        })
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        if let Some(exact) = &self.stage.exact {
            return exact.hessian(bodies, a, convex, sink);
        }
        self.near(bodies, a, |shapes, near| {
            for near in near {
                let [_, first, second] = self.energy_of(bodies, near)?;
                let (e, rows) = (near.direction(), near.rows(bodies, a));
                let arc = &shapes[near.on[1]].arcs[near.foot.arc];
                let bent = if convex { 0.0 } else { first };
                near.add_second(&rows, arc, [bent, second], sink);
                if !convex {
                    bend(bodies, near.on[0], &near.sample, a, e * first, sink);
                    bend(bodies, near.on[1], &near.foot, a, e * -first, sink);
                }
            }
            Some(())
        })
    }

    fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let depth = self.stage.exact.as_ref().map_or(0.0, |_| self.stage.width);
        let count = |body, arc| self.samples().count(bodies, body, arc);
        let apart = Apart {
            bodies,
            meeting: &self.meeting,
            count: &count,
            depth,
        };
        let reach = |start: &[Shape], least: f64| {
            let way = Way {
                bodies,
                a,
                step,
                start,
                least,
            };
            advance::pairs(&way, depth, &apart)
        };
        // Exact contact does not look for samples within the barrier.
        match &self.stage.exact {
            None => self.near(bodies, a, |shapes, near| {
                let least = near.iter().map(|n| n.at.distance).fold(self.stage.width, f64::min);
                reach(shapes, least)
            }),
            Some(_) => reach(&Self::shapes(bodies, a), 0.0),
        }
    }

    fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let exact = self.stage.due().then(|| self.hand_over(bodies, a));
        self.stage.update(bodies, a, exact)
    }

    fn active(&mut self) -> Option<&mut dyn Active> {
        self.stage.active()
    }

    fn provisional(&self) -> bool {
        self.stage.provisional()
    }

    fn narrow(&mut self, again: bool) {
        self.stage.narrow(again);
    }

    fn exact(&self) -> bool {
        self.stage.exact.is_some()
    }

    fn handed_over(&self) -> bool {
        self.stage.exact.is_some()
    }

    fn polish(&mut self) {
        self.stage.polish();
    }

    fn copy(&self) -> Box<dyn Term> {
        Box::new(self.clone())
    }

    fn forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        if let Some(exact) = &self.stage.exact {
            return exact.forces(bodies, a);
        }
        self.near(bodies, a, |shapes, near| {
            let each = near.iter().filter_map(|near| {
                let force = near.direction() * -self.energy_of(bodies, near)?[1];
                let (place, gap) = (shapes[near.on[0]].place(&near.sample), near.at.distance);
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
        })
    }
}
