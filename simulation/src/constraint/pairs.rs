//! Contact of solids with solids: a barrier between samples of each boundary and the arcs of the others.
//!
//! The energy of a sample that stands for the length `s` of its boundary, at the distance `d < D` of an arc, is
//! `kappa D s B(d / D) / 2`; both solids sample each other. Arcs are the true quadratic ones: the distance `d(a)` is the
//! least over the arc's parameter, and its derivatives are those of the foot that moves with the unknowns.

use std::cell::Cell;

use nalgebra::Vector2;

use super::nearest::{Nearest, nearest};
use super::rows::{Row, Rows, bend};
use super::shape::{Shape, box_distance, boxes_near};
use super::{Change, Force, Term, advance, barrier};
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
}

/// A sample near an arc of another solid.
struct Near {
    on: [usize; 2],
    sample: Cursor,
    foot: Cursor,
    length: f64,
    at: Nearest,
}

impl Pairs {
    /// A barrier that begins at the distance `first_width`, and narrows to `last_width` as searches succeed; forces act
    /// over that distance, so it is about the error. `stiffness` (units of stress): 0.1 of the solids' is good.
    pub fn new(first_width: f64, last_width: f64, stiffness: f64) -> Self {
        Self {
            width: first_width,
            last_width: last_width.min(first_width),
            stiffness,
        }
    }

    /// The distance below which solids push each other now.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Calls `visit` with every sample that comes as near as `within` to an arc of another solid. The visitor may narrow it.
    fn visit(&self, bodies: &Bodies, shapes: &[Shape], within: &Cell<f64>, visit: &mut dyn FnMut(Near)) {
        for (first, second) in ordered_pairs(shapes.len()) {
            let (own, other) = (&shapes[first], &shapes[second]);
            if !boxes_near(&own.bounds, &other.bounds, within.get()) {
                continue;
            }
            for (sample, part) in samples(own, &other.bounds, within.get(), &|arc| self.count(bodies, first, arc)) {
                let point = own.place(&sample);
                let near = |arc: &usize| box_distance(&other.boxes[*arc], &point) < within.get();
                for arc in (0..other.arcs.len()).filter(near) {
                    let at = nearest(&other.arcs[arc], point);
                    if at.distance < within.get() {
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
    (0..count).flat_map(move |i| (0..count).filter(move |j| *j != i).map(move |j| (i, j)))
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

impl Near {
    fn rows(&self, bodies: &Bodies, a: &[f64]) -> Rows {
        let mut rows = Rows::default();
        rows.add(bodies, self.on[0], &self.sample, a, 1.0);
        // The sample's own slope plays no part: it does not slide along its arc.
        rows.0.iter_mut().for_each(|row| row.slope = Vector2::zeros());
        rows.add(bodies, self.on[1], &self.foot, a, -1.0);
        rows
    }

    /// Unit vector from the foot to the sample.
    fn direction(&self) -> Vector2<f64> {
        self.at.offset / self.at.distance
    }

    /// The second derivative of the distance, as a form of two rows. With `f(a, u)` the distance to the point `u` of
    /// the arc it is `f_aa - f_au f_ua / f_uu` where the foot slides, `f_aa` where it sits at an end.
    fn curvature(&self, arc: &[Vector2<f64>; 3]) -> impl Fn(&Row, &Row) -> f64 + use<> {
        let (e, d) = (self.direction(), self.at.distance);
        let slope: Vector2<f64> = arc.iter().zip(line_slope(self.foot.u)).map(|(p, s)| p * s).sum();
        let bend = arc[0] - arc[1] * 2.0 + arc[2];
        let across = slope - e * e.dot(&slope);
        let second = across.norm_squared() / d - e.dot(&bend);
        let slides = self.at.inside && second > 0.0;
        move |p: &Row, q: &Row| {
            let flat = |x: &Vector2<f64>, y: &Vector2<f64>| (x.dot(y) - e.dot(x) * e.dot(y)) / d;
            let straight = flat(&p.by, &q.by);
            // f_u = -e . q'; its derivative by an unknown: rows hold the arc's part with its sign.
            let mixed = |r: &Row| e.dot(&r.slope) - flat(&slope, &r.by);
            if slides {
                straight - mixed(p) * mixed(q) / second
            } else {
                straight
            }
        }
    }
}

impl Term for Pairs {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        let mut sum = Some(0.0);
        self.visit(bodies, &Self::shapes(bodies, a), &Cell::new(self.width), &mut |near| {
            sum = sum.and_then(|sum| Some(sum + self.energy_of(&near)?[0]));
        });
        sum
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
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
        advance::pairs(bodies, a, step, &mut |shapes, within, visit| {
            self.visit(bodies, shapes, within, &mut |near| {
                visit(near.on, &near.sample, near.foot.arc, &near.at)
            });
        })
    }

    fn update(&mut self, _bodies: &Bodies, _a: &[f64]) -> Change {
        let again = self.width > self.last_width;
        self.width = (self.width * NARROWER).max(self.last_width);
        Change {
            again,
            ..Change::default()
        }
    }

    fn forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
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
