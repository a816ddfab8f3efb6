//! A half-plane behind a barrier: for scenes whose contacts change much on the way.
//!
//! Samples of the boundary push off over a small distance, as solids do from one another, and no step passes the plane.
//! The narrower the barrier, the nearer to the exact contact of [`HalfPlane`](super::HalfPlane), which is best where the way to
//! equilibrium is short.

use nalgebra::Vector2;

use super::ccd::first_fall;
use super::contact::Contact;
use super::exact::{Against, Between, Exact, Wall};
use super::rows::{Rows, bend};
use super::{Continuation, Force, Stage, barrier};
use crate::bodies::Bodies;
use crate::q9::shape::line_slope;
use crate::solid::{Cursor, Solid};
use crate::sparse::Triplets;

/// Samples of each arc; the first lies on its first node.
const SAMPLES_PER_ARC: u32 = 4;
/// A step leaves this part of every distance.
const LEFT_OF_DISTANCE: f64 = 0.1;

/// A half-plane that solids keep a little away from.
#[derive(Debug, Clone)]
pub struct HalfPlaneBarrier {
    normal: Vector2<f64>,
    /// Move a wall by changing it, by less than the gaps ([`HalfPlaneBarrier::least_gap`]) and before exact contact has begun; in exact
    /// contact by [`Constraint::move_wall`](super::Constraint::move_wall), by some widths.
    pub offset: f64,
    continuation: Continuation,
    stiffness: f64,
    samples: Vec<(usize, Cursor, f64)>,
}

impl HalfPlaneBarrier {
    /// Keeps the solids `which` out of `<x, normal> <= offset`; `normal` is scaled to length 1. Widths and stiffness as of
    /// [`SolidBarrier::new`](super::SolidBarrier::new). `None` without a direction.
    pub fn new(
        bodies: &Bodies,
        which: &[usize],
        normal: Vector2<f64>,
        offset: f64,
        widths: [f64; 2],
        stiffness: f64,
    ) -> Option<Self> {
        // An infinite component has an infinite norm and would turn into NaN.
        let normal = normal
            .try_normalize(0.0)
            .filter(|n| n.x.is_finite() && n.y.is_finite())?;
        let mut samples = Vec::new();
        for &body in which {
            let boundary = bodies.solid(body).boundary();
            for (arc, reference) in boundary.reference.iter().enumerate() {
                // The last node is left to the next arc, which begins with it.
                for k in 0..SAMPLES_PER_ARC {
                    let u = f64::from(k) * 2.0 / f64::from(SAMPLES_PER_ARC) - 1.0;
                    // The length of boundary that a sample stands for, in the reference configuration: it does not change with
                    // the state.
                    let speed: Vector2<f64> = reference.iter().zip(line_slope(u)).map(|(r, s)| r * s).sum();
                    samples.push((body, Cursor { arc, u }, speed.norm() * 2.0 / f64::from(SAMPLES_PER_ARC)));
                }
            }
        }
        Some(Self {
            normal,
            offset,
            continuation: Continuation::new(widths),
            stiffness,
            samples,
        })
    }

    /// The same, but after the narrowest barrier exact contact takes over, with the barrier's forces to begin with.
    #[must_use]
    pub fn then_exact(mut self) -> Self {
        self.continuation.want_exact();
        self
    }

    /// The offset about the origin that places are measured from.
    fn height(&self, bodies: &Bodies) -> f64 {
        self.offset - bodies.origin().dot(&self.normal)
    }

    fn gap(&self, bodies: &Bodies, a: &[f64], body: usize, cursor: &Cursor) -> f64 {
        let solid = bodies.solid(body);
        let (arc, part) = (solid.boundary().arcs[cursor.arc], bodies.part(body, a));
        let heights = arc.map(|n| solid.point_about(part, n, bodies.origin()).dot(&self.normal) - self.height(bodies));
        heights.iter().zip(cursor.weights()).map(|(h, w)| h * w).sum()
    }

    /// A number of every node of every arc, by solid; none of solids without samples.
    fn of_nodes(
        &self,
        bodies: &Bodies,
        of: impl Fn(&dyn Solid, usize) -> Vec<[Vector2<f64>; 3]>,
        less: f64,
    ) -> Vec<Vec<[f64; 3]>> {
        let mut found = vec![Vec::new(); bodies.len()];
        for (body, _, _) in &self.samples {
            if found[*body].is_empty() {
                let arcs = of(bodies.solid(*body), *body).into_iter();
                found[*body] = arcs.map(|arc| arc.map(|x| x.dot(&self.normal) - less)).collect();
            }
        }
        found
    }

    /// Heights of all nodes over the plane: several samples share a node.
    fn heights(&self, bodies: &Bodies, a: &[f64]) -> Vec<Vec<[f64; 3]>> {
        let outline = |solid: &dyn Solid, body| solid.outline_about(bodies.part(body, a), bodies.origin());
        self.of_nodes(bodies, outline, self.height(bodies))
    }

    /// The least distance of a sample to the plane.
    pub fn least_gap(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let gaps = self
            .samples
            .iter()
            .map(|(body, cursor, _)| self.gap(bodies, a, *body, cursor));
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// Samples within the barrier, with energy and derivatives by the gap; `None` among them where one is through.
    fn near<'a>(
        &'a self,
        bodies: &'a Bodies,
        a: &'a [f64],
    ) -> impl Iterator<Item = (usize, &'a Cursor, f64, Option<[f64; 3]>)> {
        let heights = self.heights(bodies, a);
        self.samples.iter().filter_map(move |(body, cursor, length)| {
            let gap = at(&heights, *body, cursor);
            // No half as between solids: the plane has no samples of its own.
            let scale =
                self.stiffness * bodies.relative_stiffness(*body) * length * self.continuation.activation_distance();
            let energy = barrier(gap / self.continuation.activation_distance()).map(|[b, first, second]| {
                [
                    scale * b,
                    scale * first / self.continuation.activation_distance(),
                    scale * second / self.continuation.activation_distance().powi(2),
                ]
            });
            (gap < self.continuation.activation_distance()).then_some((*body, cursor, gap, energy))
        })
    }
}

/// The value at a sample of what is quadratic along arcs.
fn at(nodes: &[Vec<[f64; 3]>], body: usize, cursor: &Cursor) -> f64 {
    let values = nodes[body][cursor.arc].iter().zip(cursor.weights());
    values.map(|(v, w)| v * w).sum()
}

impl Contact for HalfPlaneBarrier {
    const STAGE_WITHOUT_EXACT: Stage = Stage::FinalBarrier;

    fn continuation(&self) -> &Continuation {
        &self.continuation
    }

    fn continuation_mut(&mut self) -> &mut Continuation {
        &mut self.continuation
    }

    fn soft_energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        self.near(bodies, a).map(|(_, _, _, energy)| Some(energy?[0])).sum()
    }

    fn soft_gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let mut sum = 0.0;
        for (body, cursor, _, energy) in self.near(bodies, a) {
            let [energy, first, _] = energy?;
            let mut rows = Rows::default();
            rows.add(bodies, body, cursor, a, 1.0);
            for row in rows.0 {
                gradient[row.unknown] += first * row.by.dot(&self.normal);
            }
            sum += energy;
        }
        Some(sum)
    }

    fn soft_hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        for (body, cursor, _, energy) in self.near(bodies, a) {
            let [_, first, second] = energy?;
            let mut rows = Rows::default();
            rows.add(bodies, body, cursor, a, 1.0);
            rows.add_form(sink, |p, q| second * p.by.dot(&self.normal) * q.by.dot(&self.normal));
            if !convex {
                bend(bodies, body, cursor, a, self.normal * first, sink);
            }
        }
        Some(())
    }

    fn soft_reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let heights = self.heights(bodies, a);
        let velocities = |solid: &dyn Solid, body| solid.velocities(bodies.part(body, a), bodies.part(body, step));
        let rates = self.of_nodes(bodies, velocities, 0.0);
        let way = |(body, cursor, _): &(usize, Cursor, f64)| {
            let (solid, moves) = (bodies.solid(*body), bodies.part(*body, step));
            let swerves = solid.boundary().arcs[cursor.arc].map(|n| solid.swerve(moves, n));
            first_fall(
                (1.0 - LEFT_OF_DISTANCE) * at(&heights, *body, cursor),
                at(&rates, *body, cursor),
                // Half of 1.25, the largest sum of absolute weights of an arc's three nodes, for `t^2 / 2`.
                0.625 * swerves.into_iter().fold(0.0, f64::max),
            )
        };
        self.samples.iter().map(way).fold(1.0, f64::min)
    }

    fn soft_forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        let near = self.near(bodies, a).filter_map(|(body, cursor, gap, energy)| {
            Some(Force {
                body,
                point: bodies.local(body, cursor, a).position,
                force: self.normal * -energy?[1],
                gap,
            })
        });
        near.collect()
    }

    /// Every sample nearer than twice the width becomes a row, the others as they come near.
    fn hand_over(&self, bodies: &Bodies, a: &[f64]) -> Exact {
        let wall = Wall {
            depth: 2.0 * self.continuation.activation_distance(),
            normal: self.normal,
            offset: self.height(bodies),
            samples: self.samples.iter().map(|(body, cursor, _)| (*body, *cursor)).collect(),
        };
        let rows: Vec<(usize, Cursor, Against, f64)> = self
            .samples
            .iter()
            .filter_map(|(body, cursor, length)| {
                let gap = self.gap(bodies, a, *body, cursor);
                // By the gap in widths: the width of the energy's scale has cancelled. What is through begins without a
                // force.
                let slope = barrier(gap / self.continuation.activation_distance()).map_or(0.0, |b| b[1]);
                let row = (
                    *body,
                    *cursor,
                    wall.against(),
                    -self.stiffness * bodies.relative_stiffness(*body) * length * slope,
                );
                (gap < wall.depth).then_some(row)
            })
            .collect();
        Exact::new(Between::Plane(wall), bodies, a, rows.into_iter())
    }

    fn move_soft_wall(&mut self, by: f64) {
        self.offset += by;
    }
}
