//! Contact with a half-plane, fixed or moving (II 3.3.2), exact and without friction.
//!
//! Each cursor `M` of the boundary keeps out of `<x, n> <= offset` by a multiplier `p >= 0` and the energy
//! `(max(0, p - k g)^2 - p^2) / 2k` of its gap `g = <M, n> - offset` (Rockafellar's augmented Lagrangian). Cursors lie at
//! the nodes of the boundary; where an arc between them dips through the plane, one is added at its lowest point, as the
//! thesis adds cursors where a solid intrudes.

use nalgebra::Vector2;

use super::contact::Contact;
use super::exact::{Between, Exact, Wall};
use super::rows::{Rows, bend};
use super::{Change, Continuation, Force, Stage};
use crate::bodies::Bodies;
use crate::solid::Cursor;
use crate::sparse::Triplets;

/// Exact contact that takes over sees this deep, in sizes of the largest solid.
const DEPTH_EXTENTS: f64 = 1e-3;
/// It takes over once no multiplier changes by more than this part of the largest.
const HAND_OVER_CHANGE: f64 = 1e-2;
/// A dip less deep than this part of the largest solid is rounding.
const LEAST_DIP_EXTENTS: f64 = 1e-5;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Touch {
    body: usize,
    cursor: Cursor,
    multiplier: f64,
    /// Added at a dip: it follows the dip.
    added: bool,
}

/// A half-plane that solids keep out of.
#[derive(Debug, Clone)]
pub struct HalfPlane {
    normal: Vector2<f64>,
    /// Move a wall by changing it before exact contact has begun; by [`Constraint::move_wall`](super::Constraint::move_wall) at any time.
    pub offset: f64,
    stiffness: f64,
    touches: Vec<Touch>,
    /// The exact contact on true arcs that takes over, once it is wanted.
    continuation: Continuation,
}

impl HalfPlane {
    /// Keeps the solids `which` out of `<x, normal> <= offset`; `normal` is scaled to length 1. `stiffness` (force by
    /// length) only decides how fast forces settle: 10 to 1000 times the solids' is good. `None` without a direction.
    pub fn new(bodies: &Bodies, which: &[usize], normal: Vector2<f64>, offset: f64, stiffness: f64) -> Option<Self> {
        // An infinite component has an infinite norm and would turn into NaN.
        let normal = normal
            .try_normalize(0.0)
            .filter(|n| n.x.is_finite() && n.y.is_finite())?;
        let mut touches = Vec::new();
        for &body in which {
            for arc in 0..bodies.solid(body).boundary().arcs.len() {
                let at = |u| Touch {
                    body,
                    cursor: Cursor { arc, u },
                    multiplier: 0.0,
                    added: false,
                };
                // Each arc begins where the one before ends: its last node is that one's.
                touches.push(at(-1.0));
                // The middle of a segment is never lower than both its ends.
                if !bodies.solid(body).boundary().straight {
                    touches.push(at(0.0));
                }
            }
        }
        Some(Self {
            normal,
            offset,
            stiffness,
            touches,
            continuation: Continuation::new([DEPTH_EXTENTS * bodies.extent(); 2]),
        })
    }

    /// Takes multipliers from the gaps of a state.
    fn multiply(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let mut change = Change::default();
        for k in 0..self.touches.len() {
            let touch = self.touches[k];
            let gap = self.gap(bodies, a, &touch);
            // Rockafellar's update: the force that the search ended with, `max(0, p - k g)`, is the next multiplier.
            let next = (touch.multiplier - self.hold(bodies, &touch) * gap).max(0.0);
            change.force = change.force.max((next - touch.multiplier).abs());
            change.violation = change.violation.max(-gap);
            self.touches[k].multiplier = next;
        }
        change
    }

    /// The offset about the origin that places are measured from.
    fn height(&self, bodies: &Bodies) -> f64 {
        self.offset - bodies.origin().dot(&self.normal)
    }

    fn gap(&self, bodies: &Bodies, a: &[f64], touch: &Touch) -> f64 {
        let solid = bodies.solid(touch.body);
        let arc = solid.boundary().arcs[touch.cursor.arc];
        let part = bodies.part(touch.body, a);
        let heights = arc.map(|n| solid.point_about(part, n, bodies.origin()).dot(&self.normal) - self.height(bodies));
        heights.iter().zip(touch.cursor.weights()).map(|(h, w)| h * w).sum()
    }

    /// How fast a force settles: by the stiffness of its solid.
    fn hold(&self, bodies: &Bodies, touch: &Touch) -> f64 {
        self.stiffness * bodies.relative_stiffness(touch.body)
    }

    /// Cursors that push, with the force.
    fn pushing<'a>(&'a self, bodies: &'a Bodies, a: &'a [f64]) -> impl Iterator<Item = (&'a Touch, f64)> {
        self.touches.iter().filter_map(move |touch| {
            let push = touch.multiplier - self.hold(bodies, touch) * self.gap(bodies, a, touch);
            (push > 0.0).then_some((touch, push))
        })
    }

    /// The lowest point inside an arc, where it is a minimum: `(u, gap)`.
    fn dip(&self, bodies: &Bodies, a: &[f64], body: usize, arc: usize) -> Option<(f64, f64)> {
        let at = |u| Touch {
            body,
            cursor: Cursor { arc, u },
            multiplier: 0.0,
            added: true,
        };
        let [low, middle, high] = [-1.0, 0.0, 1.0].map(|u| self.gap(bodies, a, &at(u)));
        // The parabola of the three heights is `middle + slope u + bend u^2 / 2`. Without a bend `u` is not finite, and
        // no dip is found.
        let (slope, bend) = (0.5 * (high - low), high + low - 2.0 * middle);
        let u = -slope / bend;
        let inside = bend > 0.0 && u.abs() < 1.0;
        inside.then(|| (u, middle - 0.5 * slope * slope / bend))
    }

    /// Moves the added cursors to the dips, and adds one at every dip that has none.
    fn follow_dips(&mut self, bodies: &Bodies, a: &[f64]) -> bool {
        let mut changed = false;
        // Sorted, so that cursors come in the same order in every run.
        let bodies_here: std::collections::BTreeSet<usize> = self.touches.iter().map(|t| t.body).collect();
        for body in bodies_here {
            for arc in 0..bodies.solid(body).boundary().arcs.len() {
                let Some((u, gap)) = self.dip(bodies, a, body, arc) else {
                    continue;
                };
                let deep = gap < -LEAST_DIP_EXTENTS * bodies.extent();
                let mut own = self
                    .touches
                    .iter_mut()
                    .filter(|t| t.added && t.body == body && t.cursor.arc == arc);
                match own.next() {
                    // On a flat arc the lowest point is anywhere: a cursor moves only where the arc still dips.
                    Some(touch) if deep => {
                        changed = true;
                        touch.cursor.u = u;
                    }
                    None if deep => {
                        changed = true;
                        self.touches.push(Touch {
                            body,
                            cursor: Cursor { arc, u },
                            multiplier: 0.0,
                            added: true,
                        });
                    }
                    _ => {}
                }
            }
        }
        changed
    }
}

impl Contact for HalfPlane {
    const STAGE_WITHOUT_EXACT: Stage = Stage::Final;

    fn continuation(&self) -> &Continuation {
        &self.continuation
    }

    fn continuation_mut(&mut self) -> &mut Continuation {
        &mut self.continuation
    }

    fn soft_energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        let of = |touch: &Touch, force: f64| force * force / (2.0 * self.hold(bodies, touch));
        let constant: f64 = self.touches.iter().map(|t| of(t, t.multiplier)).sum();
        let pushing: f64 = self.pushing(bodies, a).map(|(touch, push)| of(touch, push)).sum();
        Some(pushing - constant)
    }

    fn soft_gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        for (touch, push) in self.pushing(bodies, a) {
            let mut rows = Rows::default();
            rows.add(bodies, touch.body, &touch.cursor, a, 1.0);
            for row in rows.0 {
                gradient[row.unknown] -= push * row.by.dot(&self.normal);
            }
        }
        self.soft_energy(bodies, a)
    }

    fn soft_hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        for (touch, push) in self.pushing(bodies, a) {
            let mut rows = Rows::default();
            rows.add(bodies, touch.body, &touch.cursor, a, 1.0);
            let hold = self.hold(bodies, touch);
            // The push falls by `hold` times the gap: `hold dg dg^T - push d2 g`.
            rows.add_form(sink, |p, q| hold * p.by.dot(&self.normal) * q.by.dot(&self.normal));
            if !convex {
                bend(bodies, touch.body, &touch.cursor, a, self.normal * -push, sink);
            }
        }
        Some(())
    }

    fn soft_forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        let at_work = self.touches.iter().filter(|t| t.multiplier > 0.0);
        at_work
            .map(|touch| Force {
                body: touch.body,
                point: bodies.local(touch.body, &touch.cursor, a).position,
                force: self.normal * touch.multiplier,
                gap: self.gap(bodies, a, touch),
            })
            .collect()
    }

    /// Every cursor that pushes or is near becomes a row, the others as they come near.
    fn hand_over(&self, bodies: &Bodies, a: &[f64]) -> Exact {
        // Dips have rows of their own.
        let own = || self.touches.iter().filter(|t| !t.added);
        let wall = Wall {
            depth: 2.0 * self.continuation.activation_distance(),
            normal: self.normal,
            offset: self.height(bodies),
            samples: own().map(|t| (t.body, t.cursor)).collect(),
        };
        let near = |t: &&Touch| t.multiplier > 0.0 || self.gap(bodies, a, t) < wall.depth;
        let rows: Vec<_> = own()
            .filter(near)
            .map(|t| (t.body, t.cursor, wall.against(), t.multiplier))
            .collect();
        Exact::new(Between::Plane(wall), bodies, a, rows.into_iter())
    }

    /// Settled once no multiplier changes by more than a part of the largest.
    fn settle(&mut self, bodies: &Bodies, a: &[f64]) -> (Change, bool) {
        let mut change = self.multiply(bodies, a);
        change.again = self.follow_dips(bodies, a);
        let largest = self.touches.iter().map(|t| t.multiplier).fold(0.0, f64::max);
        (change, !change.again && change.force <= HAND_OVER_CHANGE * largest)
    }

    fn move_soft_wall(&mut self, by: f64) {
        self.offset += by;
    }
}
