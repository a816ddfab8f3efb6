//! Contact of solids with solids: a barrier between samples of each boundary and the arcs of the others.
//!
//! The energy of a sample that stands for the length `s` of its boundary, at the distance `d < D` of an arc, is
//! `kappa D s B(d / D) / 2`; both solids sample each other. Arcs are the true quadratic ones: the distance `d(a)` is the
//! least over the arc's parameter, and its derivatives are those of the foot that moves with the unknowns.

use std::cell::Cell;

use nalgebra::Vector2;

use super::advance::Facing;
use super::exact::{Against, Between, Exact};
use super::near::{Near, outside_own, signed};
use super::nearest::nearest;
use super::rows::bend;
use super::shape::{Shape, box_distance, boxes_near};
use super::{Active, Change, Force, Term, advance, barrier};
use crate::q9::shape::line_slope;
use crate::solid::Cursor;
use crate::sparse::Triplets;
use crate::system::Bodies;

/// Samples of each arc, at least and at most; the first lies on its first node.
const FEWEST: u32 = 4;
const MOST: u32 = 64;
/// The barrier narrows by this factor from search to search.
const NARROWER: f64 = 0.25;

/// Keeps solids apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairs {
    /// The distance below which solids push each other.
    width: f64,
    last_width: f64,
    /// Units of stress.
    stiffness: f64,
    /// Solids that keep out of themselves.
    own: Vec<usize>,
    /// The exact contact that takes over after the last width, once it is wanted: its stiffness.
    polish: bool,
    exact: Option<Exact>,
}

impl Pairs {
    /// A barrier that begins at the distance `first_width`, and narrows to `last_width` as searches succeed; forces act
    /// over that distance, so it is about the error. `stiffness` (units of stress): 0.1 of the solids' is good.
    pub fn new(first_width: f64, last_width: f64, stiffness: f64) -> Self {
        Self {
            width: first_width,
            last_width: last_width.min(first_width),
            stiffness,
            own: Vec::new(),
            polish: false,
            exact: None,
        }
    }

    /// The same, but these solids keep out of themselves too: each sample of their boundary keeps away from all arcs but
    /// its own and the two next to it, from the outside. The width must be less than an arc is long.
    #[must_use]
    pub fn with_own(mut self, bodies: &[usize]) -> Self {
        self.own = bodies.to_vec();
        self
    }

    /// The same, but after the narrowest barrier exact contact takes over, with the barrier's forces to begin with: samples
    /// keep out of the true arcs, and so do closest points of arcs between them.
    #[must_use]
    pub fn polished(mut self) -> Self {
        self.polish = true;
        self
    }

    /// Hands the forces over to the exact contact: every sample nearer than twice the width becomes a row.
    fn hand_over(&self, bodies: &Bodies, a: &[f64]) -> Exact {
        let between = Between::Solids {
            depth: 2.0 * self.width,
            own: self.own.clone(),
        };
        let mut rows: Vec<(usize, Cursor, Against, f64)> = Vec::new();
        let reach = Cell::new(2.0 * self.width);
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
        self.width
    }

    /// Calls `visit` with every sample that comes as near as `within` to an arc of another solid. The visitor may narrow it.
    fn visit(&self, bodies: &Bodies, shapes: &[Shape], within: &Cell<f64>, visit: &mut dyn FnMut(Near)) {
        for (first, second) in ordered_pairs(shapes.len()) {
            let (own, other, itself) = (&shapes[first], &shapes[second], first == second);
            if itself && !self.own.contains(&first) {
                continue;
            }
            if !boxes_near(&own.bounds, &other.bounds, within.get()) {
                continue;
            }
            for (sample, part) in samples(own, &other.bounds, within.get(), &|arc| self.count(bodies, first, arc)) {
                let point = own.place(&sample);
                let near = |arc: &usize| box_distance(&other.boxes[*arc], &point) < within.get();
                for arc in (0..other.arcs.len()).filter(near) {
                    let at = nearest(&other.arcs[arc], point);
                    let own_kind = itself && !outside_own(bodies, first, &other.arcs[arc], [sample.arc, arc], &at);
                    if at.distance < within.get() && !own_kind {
                        let length = reference_speed(bodies, first, &sample) * part;
                        let foot = Cursor { arc, u: at.u };
                        visit(Near {
                            on: [first, second],
                            sample,
                            foot,
                            length,
                            at,
                        });
                    }
                }
            }
        }
    }

    /// Samples of an arc: so many that between them, on two arcs of its bend, the distance changes by less than the width.
    ///
    /// An arc that departs by `s` from its chord departs by `s / n^2` from the chords of `n` pieces.
    fn count(&self, bodies: &Bodies, body: usize, arc: usize) -> u32 {
        let boundary = bodies.solid(body).boundary();
        let [a, b, c] = boundary.reference[arc];
        let depth = (b - (a + c) * 0.5).norm();
        let wanted = (3.0 * (depth / self.width).sqrt()).ceil();
        (wanted.min(f64::from(MOST)) as u32).max(FEWEST)
    }

    /// Energy of a pair and its two derivatives by the distance.
    fn energy_of(&self, near: &Near) -> Option<[f64; 3]> {
        let scale = 0.5 * self.stiffness * near.length * self.width;
        let [b, first, second] = barrier(near.at.distance / self.width)?;
        Some([
            scale * b,
            scale * first / self.width,
            scale * second / (self.width * self.width),
        ])
    }

    fn shapes(bodies: &Bodies, a: &[f64]) -> Vec<Shape> {
        (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect()
    }
}

fn ordered_pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (0..count).map(move |j| (i, j)))
}

/// Samples of the arcs that come near a box, each with the part of its arc's parameter that it stands for.
fn samples<'a>(
    own: &'a Shape,
    other: &'a [Vector2<f64>; 2],
    within: f64,
    count: &'a dyn Fn(usize) -> u32,
) -> impl Iterator<Item = (Cursor, f64)> + 'a {
    let arcs = (0..own.arcs.len()).filter(move |arc| boxes_near(&own.boxes[*arc], other, within));
    arcs.flat_map(move |arc| {
        let part = 2.0 / f64::from(count(arc));
        (0..count(arc)).map(move |k| {
            (
                Cursor {
                    arc,
                    u: f64::from(k) * part - 1.0,
                },
                part,
            )
        })
    })
}

/// Reference length by parameter at a sample.
fn reference_speed(bodies: &Bodies, body: usize, sample: &Cursor) -> f64 {
    let reference = &bodies.solid(body).boundary().reference[sample.arc];
    let speed: Vector2<f64> = reference.iter().zip(line_slope(sample.u)).map(|(r, s)| r * s).sum();
    speed.norm()
}

impl Term for Pairs {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        if let Some(exact) = &self.exact {
            return exact.energy(bodies, a);
        }
        let mut sum = Some(0.0);
        self.visit(bodies, &Self::shapes(bodies, a), &Cell::new(self.width), &mut |near| {
            sum = sum.and_then(|sum| Some(sum + self.energy_of(&near)?[0]));
        });
        sum
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        if let Some(exact) = &self.exact {
            return exact.gradient(bodies, a, gradient);
        }
        let mut sum = Some(0.0);
        self.visit(bodies, &Self::shapes(bodies, a), &Cell::new(self.width), &mut |near| {
            let Some([energy, first, _]) = self.energy_of(&near) else {
                sum = None;
                return;
            };
            let pull = near.direction() * first;
            for row in near.rows(bodies, a).0 {
                gradient[row.unknown] += pull.dot(&row.by);
            }
            sum = sum.map(|sum| sum + energy);
        });
        sum
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        if let Some(exact) = &self.exact {
            return exact.hessian(bodies, a, convex, sink);
        }
        let shapes = Self::shapes(bodies, a);
        let mut whole = Some(());
        self.visit(bodies, &shapes, &Cell::new(self.width), &mut |near| {
            let Some([_, first, second]) = self.energy_of(&near) else {
                whole = None;
                return;
            };
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
        });
        whole
    }

    fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let depth = self.exact.as_ref().map_or(0.0, |_| self.width);
        advance::pairs(bodies, a, step, depth, &mut |shapes, within, visit| {
            let reach = Cell::new(0.0);
            reach.set(within.get() + depth);
            self.visit(bodies, shapes, &reach, &mut |near| {
                let (mut direction, mut distance) = (near.direction(), near.at.distance);
                if depth > 0.0 {
                    (direction, distance) = signed(&near, &shapes[near.on[1]].arcs[near.foot.arc]);
                }
                // The far side of a solid is no concern of a sample that has not come through the near one.
                if distance > -2.0 * depth || depth == 0.0 {
                    visit(Facing {
                        on: near.on,
                        sample: near.sample,
                        arc: near.foot.arc,
                        direction,
                        distance,
                    });
                }
                reach.set(within.get() + depth);
            });
        })
    }

    fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        if let Some(exact) = &mut self.exact {
            return exact.update(bodies, a);
        }
        let mut again = self.width > self.last_width;
        if self.polish && !again {
            self.exact = Some(self.hand_over(bodies, a));
            again = true;
        }
        self.width = (self.width * NARROWER).max(self.last_width);
        Change {
            again,
            ..Change::default()
        }
    }

    fn active(&mut self) -> Option<&mut dyn Active> {
        self.exact.as_mut().map(|exact| exact as &mut dyn Active)
    }

    fn provisional(&self) -> bool {
        self.exact.is_none() && (self.polish || self.width > self.last_width)
    }

    fn narrow(&mut self, again: bool) {
        self.polish &= again;
        if again {
            self.width *= NARROWER;
        }
        self.last_width = self.width;
    }

    fn exact(&self) -> bool {
        self.exact.is_some()
    }

    fn copy(&self) -> Box<dyn Term> {
        Box::new(self.clone())
    }

    fn forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        if let Some(exact) = &self.exact {
            return exact.forces(bodies, a);
        }
        let mut forces = Vec::new();
        let shapes = Self::shapes(bodies, a);
        self.visit(bodies, &shapes, &Cell::new(self.width), &mut |near| {
            let Some([_, first, _]) = self.energy_of(&near) else {
                return;
            };
            let force = near.direction() * -first;
            let (point, gap) = (shapes[near.on[0]].place(&near.sample), near.at.distance);
            forces.push(Force {
                body: near.on[0],
                point,
                force,
                gap,
            });
            forces.push(Force {
                body: near.on[1],
                point: point - near.at.offset,
                force: -force,
                gap,
            });
        });
        forces
    }
}
