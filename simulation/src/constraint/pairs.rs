//! Contact of solids with solids: a barrier between samples of each boundary and the arcs of the others.
//!
//! The energy of a sample that stands for the length `s` of its boundary, at the distance `d < D` of an arc, is
//! `kappa D s B(d / D) / 2`; both solids sample each other. Arcs are the true quadratic ones: the distance `d(a)` is the
//! least over the arc's parameter, and its derivatives are those of the foot that moves with the unknowns.

use std::cell::{Cell, RefCell};

use nalgebra::Vector2;

use super::apart::Apart;
use super::broad::{Place, near_arcs};
use super::exact::{Against, Between, Exact};
use super::meeting::Meeting;
use super::near::{Near, outside_own};
use super::nearest::nearest;
use super::rows::bend;
use super::shape::{Shape, box_distance, boxes_near};
use super::stage::Stage;
use super::{Active, Change, Force, Term, advance, barrier};
use crate::q9::shape::line_slope;
use crate::solid::Cursor;
use crate::sparse::Triplets;
use crate::system::Bodies;

/// Samples of each arc, at least and at most; the first lies on its first node.
const FEWEST: u32 = 4;
const MOST: u32 = 64;
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
    /// over that distance, so it is about the error. `stiffness` (units of stress): 0.1 of the solids' is good.
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
            depth: 2.0 * self.stage.width,
            meeting: self.meeting.clone(),
        };
        let mut rows: Vec<(usize, Cursor, Against, f64)> = Vec::new();
        let reach = Cell::new(2.0 * self.stage.width);
        self.visit(bodies, &Self::shapes(bodies, a), &reach, &mut |near| {
            let force = self.energy_of(&near).map_or(0.0, |e| -e[1]);
            let [body, other] = near.on;
            let foot = near.foot;
            // An arc's end and the next one's start are one point.
            let corner = foot.u.abs() >= 1.0;
            let known = rows.iter_mut().find(|(b, s, against, _)| {
                *b == body
                    && *s == near.sample
                    && corner
                    && matches!(against, Against::Arc { other: o, foot: f } if *o == other && f.u.abs() >= 1.0)
            });
            match known {
                Some(row) => row.3 += force,
                None => rows.push((body, near.sample, Against::Arc { other, foot }, force)),
            }
        });
        Exact::new(between, bodies, a, rows.into_iter())
    }

    /// The distance below which solids push each other now.
    pub fn width(&self) -> f64 {
        self.stage.width
    }

    /// Calls `visit` with every sample that comes as near as `within` to an arc of another solid. The visitor may narrow it.
    fn visit(&self, bodies: &Bodies, shapes: &[Shape], within: &Cell<f64>, visit: &mut dyn FnMut(Near)) {
        for [one, two] in near_arcs(shapes, within.get()) {
            if !self.meeting.of(one[0] as usize, two[0] as usize) {
                continue;
            }
            self.visit_arcs(bodies, shapes, [one, two], within, visit);
            self.visit_arcs(bodies, shapes, [two, one], within, visit);
        }
    }

    /// Samples of the first arc against the second.
    fn visit_arcs(
        &self,
        bodies: &Bodies,
        shapes: &[Shape],
        [own, other]: [Place; 2],
        within: &Cell<f64>,
        visit: &mut dyn FnMut(Near),
    ) {
        let ([first, arc], [second, against]) = (own.map(|k| k as usize), other.map(|k| k as usize));
        let (shape, nodes, bounds) = (
            &shapes[first],
            &shapes[second].arcs[against],
            &shapes[second].boxes[against],
        );
        if !boxes_near(&shape.boxes[arc], bounds, within.get()) {
            return;
        }
        let count = self.count(bodies, first, arc);
        let part = 2.0 / f64::from(count);
        for k in 0..count {
            let u = f64::from(k) * part - 1.0;
            let sample = Cursor { arc, u };
            let point = shape.place(&sample);
            if box_distance(bounds, &point) >= within.get() {
                continue;
            }
            let at = nearest(nodes, point);
            let own_kind = first == second && !outside_own(bodies, first, nodes, [arc, against], &at);
            if at.distance < within.get() && !own_kind {
                let length = reference_speed(bodies, first, &sample) * part;
                visit(Near {
                    on: [first, second],
                    sample,
                    foot: Cursor { arc: against, u: at.u },
                    length,
                    at,
                });
            }
        }
    }

    /// Every sample within the barrier in a state, found once: energy, gradient and second derivatives ask for the same
    /// state one after the other.
    fn near<T>(&self, bodies: &Bodies, a: &[f64], look: impl FnOnce(&[Shape], &[Near]) -> T) -> T {
        let mut seen = self.seen.0.borrow_mut();
        if !seen.as_ref().is_some_and(|s| s.width == self.stage.width && s.a == a) {
            let (shapes, mut near) = (Self::shapes(bodies, a), Vec::new());
            self.visit(bodies, &shapes, &Cell::new(self.stage.width), &mut |n| near.push(n));
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

    /// Samples of an arc: so many that between them, on two arcs of its bend, the distance changes by less than the width.
    ///
    /// An arc that departs by `s` from its chord departs by `s / n^2` from the chords of `n` pieces.
    fn count(&self, bodies: &Bodies, body: usize, arc: usize) -> u32 {
        let boundary = bodies.solid(body).boundary();
        let [a, b, c] = boundary.reference[arc];
        let depth = (b - (a + c) * 0.5).norm();
        let wanted = (3.0 * (depth / self.stage.width).sqrt()).ceil();
        (wanted.min(f64::from(MOST)) as u32).max(FEWEST)
    }

    /// Energy of a pair and its two derivatives by the distance.
    fn energy_of(&self, near: &Near) -> Option<[f64; 3]> {
        let scale = 0.5 * self.stiffness * near.length * self.stage.width;
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

/// Reference length by parameter at a sample.
fn reference_speed(bodies: &Bodies, body: usize, sample: &Cursor) -> f64 {
    let reference = &bodies.solid(body).boundary().reference[sample.arc];
    let speed: Vector2<f64> = reference.iter().zip(line_slope(sample.u)).map(|(r, s)| r * s).sum();
    speed.norm()
}

impl Term for Pairs {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        if let Some(exact) = &self.stage.exact {
            return exact.energy(bodies, a);
        }
        self.near(bodies, a, |_, near| {
            near.iter().map(|near| Some(self.energy_of(near)?[0])).sum()
        })
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        if let Some(exact) = &self.stage.exact {
            return exact.gradient(bodies, a, gradient);
        }
        self.near(bodies, a, |_, near| {
            let mut sum = 0.0;
            for near in near {
                let [energy, first, _] = self.energy_of(near)?;
                let pull = near.direction() * first;
                for row in near.rows(bodies, a).0 {
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
                let [_, first, second] = self.energy_of(near)?;
                let (e, rows) = (near.direction(), near.rows(bodies, a));
                let curvature = near.curvature(&shapes[near.on[1]].arcs[near.foot.arc]);
                let bent = if convex { 0.0 } else { first };
                rows.add_form(sink, |p, q| {
                    second * e.dot(&p.by) * e.dot(&q.by) + bent * curvature(p, q)
                });
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
        let count = |body, arc| self.count(bodies, body, arc);
        let apart = Apart {
            bodies,
            meeting: &self.meeting,
            count: &count,
            depth,
        };
        advance::pairs(bodies, a, step, depth, &apart)
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
                let force = near.direction() * -self.energy_of(near)?[1];
                let (point, gap) = (shapes[near.on[0]].place(&near.sample), near.at.distance);
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
