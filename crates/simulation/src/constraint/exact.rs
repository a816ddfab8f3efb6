//! Exact contact without friction: rows on true arcs, whose forces are unknowns of their own.
//!
//! A row is a point of a boundary that keeps out of an arc of another, or of a half-plane: four on each arc, and points
//! added where arcs come closest between them. With `g` its signed gap, `p` its force and `s > 0` a slack, each step of Newton's
//! method aims at `p s = w` for all rows near contact, `g = s` and the balance of forces, with `w` falling to next to nothing
//! (a primal-dual interior method). Unlike a barrier it converges as fast at the end as anywhere, and unlike an active set
//! it has nothing to cycle through where solids lie flat on one another and forces have many ways to share out. Gaps end above
//! zero: `w / p`. Rows come and go with what is near, and their aim fades out there ([`central_path`]).

mod active;
mod central_path;
mod closest_points;
mod contact_row;
mod detect;
mod wall;

use std::sync::Arc;

use super::ccd::Way;
use super::last_state::LastState;
use super::samples::Samples;
use super::shape::Shape;
use super::{Active, Change, Force, ccd_pairs};
use crate::bodies::Bodies;
use crate::solid::Cursor;
use crate::sparse::Triplets;
use central_path::Aim;
pub(super) use contact_row::Against;
use contact_row::{Row, Touch};
pub(super) use detect::Between;
pub(super) use wall::Wall;

/// Rows keep this far apart, in sizes of the largest solid: arcs may come as much nearer to one another between them without
/// touching, and forces of 300 loads times their gaps stay below 1e-8 of load and size.
const KEEP_EXTENTS: f64 = 3e-11;
/// A loaded row keeps this part of that as its gap beyond it.
const LOADED_ROW_GAP: f64 = 1e-3;
/// A row that begins violated begins with this part of the depth looked at as its slack.
const FIRST_ROOM: f64 = 0.01;
/// Rows nearer than this part of their arc are one, where their normals differ by less too.
const SAME_ARC_PART: f64 = 1e-7;
/// A row farther away than this many depths is none any more.
const GONE_DEPTHS: f64 = 1.5;

/// Rows at work.
#[derive(Debug, Clone)]
pub(super) struct Exact {
    pub(super) between: Between,
    rows: Vec<Row>,
    /// What steps aim at.
    aim: Option<Aim>,
    /// How slacks and forces change in the last Newton step.
    changes: Vec<[f64; 2]>,
    /// The slack that a new row begins with.
    least: f64,
    /// How far rows keep apart, so that arcs between them have room: a length.
    keep: f64,
    /// Each row in the last state; `None` for one that has lost its foot.
    known: LastState<Vec<Option<Touch>>>,
}

impl Exact {
    /// Rows `(solid, sample, against what, force)` that take over in the state `a` from a barrier.
    pub(super) fn new(
        between: Between,
        bodies: &Bodies,
        a: &[f64],
        rows: impl Iterator<Item = (usize, Cursor, Against, f64)>,
    ) -> Self {
        let shapes = Self::shapes(bodies, a);
        let mut exact = Self {
            // Until `review` knows the deepest dip.
            least: FIRST_ROOM * between.depth(),
            between,
            rows: Vec::new(),
            aim: None,
            changes: Vec::new(),
            keep: KEEP_EXTENTS * bodies.extent(),
            known: LastState::default(),
        };
        for (body, sample, against, force) in rows {
            exact.put(Row::new(body, sample, against, force), bodies, &shapes);
        }
        exact.add_closest(bodies, &shapes);
        exact
    }

    /// Adds a row, or its force to the one that is the same.
    fn put(&mut self, row: Row, bodies: &Bodies, shapes: &[Shape]) {
        let Some(touch) = self.touch(&row, bodies, shapes) else {
            return;
        };
        let own = |r: &Row| r.body == row.body && r.sample == row.sample && !r.slides;
        let same = |r: &Row| own(r) && r.same(&touch, shapes);
        match self.rows.iter_mut().find(|r| same(r)) {
            Some(known) => known.force += row.force,
            // Deeper than allowed: from some room, with the force that it has.
            None => self.rows.push(Row {
                slack: if touch.gap > 0.0 { touch.gap } else { self.least },
                against: touch.against,
                normal: touch.normal,
                ..row
            }),
        }
    }

    /// Adds the closest points of arcs that are near one another, and the lowest ones over a half-plane.
    fn add_closest(&mut self, bodies: &Bodies, shapes: &[Shape]) {
        let (depth, rows) = (self.between.depth(), &mut self.rows);
        let mut put = |row: Row, gap: f64| {
            rows.push(Row {
                slack: gap.max(0.0),
                slides: true,
                ..row
            });
        };
        self.between
            .dips(bodies, shapes, depth, false, &mut |[body, other], sample, foot| {
                let against = Against::Arc { other, foot: foot.on };
                put(Row::new(body, sample, against, 0.0), foot.gap);
            });
        self.between.lowest(bodies, shapes, &mut |body, sample, against, gap| {
            if gap < depth {
                put(Row::new(body, sample, against, 0.0), gap);
            }
        });
    }

    /// Adds the samples that have come near and have no row yet.
    fn add_near(&mut self, bodies: &Bodies, shapes: &[Shape]) {
        let mut near = Vec::new();
        self.between.samples(bodies, shapes, &mut |body, sample, against| {
            near.push(Row::new(body, sample, against, 0.0));
        });
        near.into_iter().for_each(|row| self.put(row, bodies, shapes));
    }

    /// Moves a wall along its normal, with the forces and slacks of its rows as they are.
    pub(super) fn move_wall(&mut self, by: f64) {
        if let Between::Plane(wall) = &mut self.between {
            wall.offset += by;
        }
        for row in &mut self.rows {
            if let Against::Plane { offset, .. } = &mut row.against {
                *offset += by;
            }
        }
        // Gaps have changed, the state has not.
        self.known.forget();
    }

    fn shapes(bodies: &Bodies, a: &[f64]) -> Vec<Shape> {
        (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect()
    }

    /// Every row in a state, found once: one step asks for the same state several times. `None` where one with a force has
    /// lost its foot.
    fn touches(&self, bodies: &Bodies, a: &[f64]) -> Option<Arc<Vec<Option<Touch>>>> {
        let each = self.each(bodies, a);
        let lost = |(row, touch): (&Row, &Option<Touch>)| touch.is_none() && row.force > 0.0;
        let any = self.rows.iter().zip(each.iter()).any(lost);
        (!any).then_some(each)
    }

    fn each(&self, bodies: &Bodies, a: &[f64]) -> Arc<Vec<Option<Touch>>> {
        self.known.at(a, || {
            let shapes = Self::shapes(bodies, a);
            self.rows.iter().map(|row| self.touch(row, bodies, &shapes)).collect()
        })
    }

    /// A row now; its gap is what it has beyond the distance kept.
    fn touch(&self, row: &Row, bodies: &Bodies, shapes: &[Shape]) -> Option<Touch> {
        let mut touch = row.touch(bodies, shapes)?;
        touch.gap -= self.keep;
        Some(touch)
    }

    fn aim_of(&self, row: &Row) -> Option<Aim> {
        self.aim.map(|aim| aim.of(row.force, LOADED_ROW_GAP * self.keep))
    }

    /// The force that the gradient holds: that of the next step's aim, or the row's own.
    fn push(&self, row: &Row, touch: &Touch) -> f64 {
        // The aim's force linearised at the slack: Newton's method makes gap and slack equal in the same step.
        let aimed = |aim: Aim| aim.force(row.slack) - aim.stiffness(row.force, row.slack) * (touch.gap - row.slack);
        self.aim_of(row).map_or(row.force, aimed)
    }

    /// How it falls with the gap.
    fn stiffness(&self, row: &Row) -> f64 {
        self.aim_of(row)
            // Without an aim, `p s` is to stay as it is: `dp / ds = -p / s`.
            .map_or(row.force / row.slack, |aim| aim.stiffness(row.force, row.slack))
    }

    /// Zero: the search with these rows has no energy to lower. `None` where a row has lost its foot.
    pub(super) fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        self.touches(bodies, a).map(|_| 0.0)
    }

    pub(super) fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        for (row, touch) in self.rows.iter().zip(self.touches(bodies, a)?.iter()) {
            let Some(touch) = touch else { continue };
            let push = self.push(row, touch);
            if push == 0.0 {
                continue;
            }
            for r in touch.rows(bodies, a).0 {
                gradient[r.unknown] -= push * touch.normal.dot(&r.by);
            }
        }
        Some(0.0)
    }

    pub(super) fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        for (row, touch) in self.rows.iter().zip(self.touches(bodies, a)?.iter()) {
            let Some(touch) = touch else { continue };
            let stiffness = self.stiffness(row);
            if stiffness > 0.0 || row.force > 0.0 {
                touch.add_second(bodies, a, stiffness, row.force, convex, sink);
            }
        }
        Some(())
    }

    /// The part of a step that keeps what has no row yet out of a wall, or out of other solids by more than the barrier's width.
    pub(super) fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        match &self.between {
            Between::Plane(wall) => wall.reach(bodies, a, step),
            Between::Solids { width, meeting } => {
                let samples = Samples { meeting, width: *width };
                let start = &Self::shapes(bodies, a);
                let way = Way {
                    bodies,
                    a,
                    step,
                    start,
                    // Rows may lie deeper than zero: no distance is known that all pairs have.
                    least: 0.0,
                };
                ccd_pairs::reach(&way, samples, *width)
            }
        }
    }

    /// Nothing to take over: forces are those found.
    pub(super) fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let progress = self.review(bodies, a, true);
        Change {
            violation: progress.violation,
            ..Change::default()
        }
    }

    /// The forces at work, on both solids, of all rows that are near.
    pub(super) fn forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        let mut forces = Vec::new();
        for (row, touch) in self.rows.iter().zip(self.each(bodies, a).iter()) {
            let Some(touch) = touch.filter(|touch| touch.gap < self.between.depth()) else {
                continue;
            };
            // Rows measure from the distance that they keep; what is reported is the distance of the arcs.
            let gap = touch.gap + self.keep;
            let force = touch.normal * row.force;
            let point = bodies.local(row.body, &row.sample, a).position;
            forces.push(Force {
                body: row.body,
                point,
                force,
                gap,
            });
            if let Against::Arc { other, .. } = row.against {
                let point = point - touch.normal * gap;
                forces.push(Force {
                    body: other,
                    point,
                    force: -force,
                    gap,
                });
            }
        }
        forces
    }
}
