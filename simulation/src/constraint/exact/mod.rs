//! Exact contact without friction: rows on true arcs, whose forces are unknowns of their own.
//!
//! A row is a point of a boundary that keeps out of an arc of another, or of a half-plane: four on each arc, and points
//! added where arcs come closest between them. With `g` its signed gap, `p` its force and `s > 0` a slack, each step of Newton's
//! method aims at `p s = w` for all rows, `g = s` and the balance of forces, with `w` falling to next to nothing
//! (a primal-dual interior method). Unlike a barrier it converges as fast at the end as anywhere, and unlike an active set
//! it has nothing to cycle through where solids lie flat on one another and forces have many ways to share out. Gaps end above
//! zero: `w / p`.

mod detect;
mod dip;
mod row;

use std::cell::{Ref, RefCell};

use super::shape::Shape;
use super::{Active, Change, Closest, Force, Progress};
use crate::solid::Cursor;
use crate::sparse::Triplets;
use crate::system::Bodies;
pub(super) use detect::Between;
pub(super) use row::Against;
use row::{Row, Touch};

/// A slack falls to this part of itself in one step at most; a force too.
const TO_BOUNDARY: f64 = 0.01;
/// Rows keep this far apart, in sizes of the largest solid: arcs may come as much nearer to one another between them without
/// touching, and forces of 300 loads times their gaps stay below 1e-8 of load and size.
const KEEP: f64 = 3e-11;
/// A new row begins with this part of the largest force at most.
const FIRST_FORCE: f64 = 0.01;
/// A row that begins violated begins with this part of the depth looked at as its slack.
const FIRST_ROOM: f64 = 0.01;
/// Rows nearer than this part of their arc are one.
const SAME: f64 = 1e-7;
/// Dips less deep than this part of the largest solid are none.
const DIP: f64 = 1e-13;

/// Rows at work.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Exact {
    pub(super) between: Between,
    rows: Vec<Row>,
    /// The work that steps aim at.
    aim: Option<f64>,
    /// How slacks and forces change in the last Newton step.
    changes: Vec<[f64; 2]>,
    /// The slack that a new row begins with.
    least: f64,
    /// How far rows keep apart, so that arcs between them have room: a length.
    keep: f64,
    known: Known,
}

/// The rows in the last state that was asked for: no part of what the term is.
#[derive(Debug, Default)]
struct Known(RefCell<(Vec<f64>, Vec<Option<Touch>>)>);

impl Clone for Known {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Known {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Exact {
    /// Rows `(solid, sample, against what, force)` that take over in the state `a` from a barrier.
    pub(super) fn new(
        between: Between,
        bodies: &Bodies,
        a: &[f64],
        rows: impl Iterator<Item = (usize, Cursor, Against, f64)>,
    ) -> Self {
        let (shapes, keep) = (Self::shapes(bodies, a), KEEP * bodies.extent());
        // Deeper than allowed: from some room, with the force that it has.
        let room = |gap: f64| if gap > 0.0 { gap } else { FIRST_ROOM * between.depth() };
        let row = |(body, sample, against, force): (usize, Cursor, Against, f64)| {
            let row = Row::new(body, sample, against, force);
            let slack = room(row.touch(bodies, &shapes)?.gap - keep);
            Some(Row { slack, ..row })
        };
        let mut rows: Vec<Row> = rows.filter_map(row).collect();
        Self::add_closest(&between, bodies, &shapes, &mut rows);
        Self {
            least: FIRST_ROOM * between.depth(),
            between,
            rows,
            aim: None,
            changes: Vec::new(),
            keep,
            known: Known::default(),
        }
    }

    /// Adds the closest points of arcs that are near one another, and the lowest ones over a half-plane.
    fn add_closest(between: &Between, bodies: &Bodies, shapes: &[Shape], rows: &mut Vec<Row>) {
        let depth = between.depth();
        let mut put = |row: Row, gap: f64, slides: bool| {
            rows.push(Row {
                slack: gap.max(0.0),
                slides,
                ..row
            });
        };
        between.dips(bodies, shapes, depth, false, &mut |[body, other], sample, foot| {
            let against = Against::Arc { other, foot: foot.on };
            put(Row::new(body, sample, against, 0.0), foot.gap, true);
        });
        between.lowest(bodies, shapes, &mut |body, sample, against, gap| {
            if gap < depth {
                put(Row::new(body, sample, against, 0.0), gap, true);
            }
        });
    }

    fn shapes(bodies: &Bodies, a: &[f64]) -> Vec<Shape> {
        (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect()
    }

    /// Every row in a state, found once: one step asks for the same state several times. `None` where one has lost its foot.
    fn touches(&self, bodies: &Bodies, a: &[f64]) -> Option<Vec<Touch>> {
        self.each(bodies, a).iter().copied().collect()
    }

    fn each(&self, bodies: &Bodies, a: &[f64]) -> Ref<'_, Vec<Option<Touch>>> {
        let known = |known: &(Vec<f64>, Vec<Option<Touch>>)| known.0 == a && known.1.len() == self.rows.len();
        if !known(&self.known.0.borrow()) {
            let shapes = Self::shapes(bodies, a);
            let touches = self.rows.iter().map(|row| self.touch(row, bodies, &shapes)).collect();
            *self.known.0.borrow_mut() = (a.to_vec(), touches);
        }
        Ref::map(self.known.0.borrow(), |known| &known.1)
    }

    /// A row now; its gap is what it has beyond the distance kept.
    fn touch(&self, row: &Row, bodies: &Bodies, shapes: &[Shape]) -> Option<Touch> {
        let mut touch = row.touch(bodies, shapes)?;
        touch.gap -= self.keep;
        Some(touch)
    }

    /// The force that the gradient holds: that of the next step's aim, or the row's own.
    fn push(&self, row: &Row, touch: &Touch) -> f64 {
        let aimed = |work: f64| (work - row.force * (touch.gap - row.slack)) / row.slack;
        self.aim.map_or(row.force, aimed)
    }

    /// Zero: the search with these rows has no energy to lower. `None` where a row has lost its foot.
    pub(super) fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        self.touches(bodies, a).map(|_| 0.0)
    }

    pub(super) fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        for (row, touch) in self.rows.iter().zip(self.touches(bodies, a)?) {
            let push = self.push(row, &touch);
            for r in touch.rows(bodies, a).0 {
                gradient[r.unknown] -= push * touch.normal.dot(&r.by);
            }
        }
        Some(0.0)
    }

    pub(super) fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        for (row, touch) in self.rows.iter().zip(self.touches(bodies, a)?) {
            touch.add_second(bodies, a, row.force / row.slack, row.force, convex, sink);
        }
        Some(())
    }

    /// Nothing to take over: forces are those found.
    pub(super) fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let progress = self.review(bodies, a, Closest::All);
        Change {
            violation: progress.violation,
            ..Change::default()
        }
    }

    /// Points where arcs are closest, and deeper in one another than the rows let them.
    fn add_dips(&mut self, bodies: &Bodies, shapes: &[Shape], depth: f64, flat: bool) -> (bool, f64) {
        let (rows, mut deepest, mut added) = (&mut self.rows, 0.0_f64, false);
        let mut dip = |body: usize, sample: Cursor, against: Against, gap: f64| {
            if gap >= 0.0 {
                return;
            }
            deepest = deepest.max(-gap);
            let place = shapes[body].place(&sample);
            let size = (shapes[body].arcs[sample.arc][2] - shapes[body].arcs[sample.arc][0]).norm();
            let same = |r: &Row| {
                let near = (shapes[r.body].place(&r.sample) - place).norm() < SAME * size;
                near && r.body == body && r.against.arc() == against.arc()
            };
            if gap < -depth && !rows.iter().any(same) {
                added = true;
                rows.push(Row {
                    slides: true,
                    ..Row::new(body, sample, against, 0.0)
                });
            }
        };
        self.between
            .dips(bodies, shapes, 0.0, flat, &mut |[body, other], sample, foot| {
                dip(body, sample, Against::Arc { other, foot: foot.on }, foot.gap);
            });
        self.between.lowest(bodies, shapes, &mut |body, sample, against, gap| {
            dip(body, sample, against, gap)
        });
        (added, deepest)
    }

    /// The forces at work, on both solids.
    pub(super) fn forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        let touches = self.touches(bodies, a).unwrap_or_default();
        let mut forces = Vec::new();
        for (row, touch) in self.rows.iter().zip(touches) {
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

impl Active for Exact {
    fn aim(&mut self, work: Option<f64>) {
        self.aim = work;
        let Some(work) = work else { return };
        let largest = self.rows.iter().map(|r| r.force).fold(0.0, f64::max);
        for row in &mut self.rows {
            if row.slack <= 0.0 || row.force <= 0.0 {
                // A new row, violated or without a force: with little of both, or it would throw all others off.
                let room = if largest > 0.0 {
                    work / (FIRST_FORCE * largest)
                } else {
                    0.0
                };
                row.slack = row.slack.max(self.least).max(room);
                row.force = row.force.max(work / row.slack);
            }
        }
    }

    fn limits(&mut self, bodies: &Bodies, a: &[f64], step: &[f64]) -> [f64; 2] {
        let mut parts = [1.0_f64; 2];
        self.changes.clear();
        let (Some(touches), Some(work)) = (self.touches(bodies, a), self.aim) else {
            return parts;
        };
        for (row, touch) in self.rows.iter().zip(&touches) {
            let rate: f64 = touch
                .rows(bodies, a)
                .0
                .iter()
                .map(|r| touch.normal.dot(&r.by) * step[r.unknown])
                .sum();
            let slack = rate + touch.gap - row.slack;
            let force = (work - row.force * slack) / row.slack - row.force;
            let most = |value: f64, by: f64| {
                if by < 0.0 {
                    (TO_BOUNDARY - 1.0) * value / by
                } else {
                    1.0
                }
            };
            parts = [
                parts[0].min(most(row.slack, slack)),
                parts[1].min(most(row.force, force)),
            ];
            self.changes.push([slack, force]);
        }
        parts
    }

    fn take(&mut self, parts: [f64; 2]) {
        for (row, [slack, force]) in self.rows.iter_mut().zip(&self.changes) {
            row.slack += parts[0] * slack;
            row.force += parts[1] * force;
        }
    }

    fn merit(&self, bodies: &Bodies, a: &[f64], part: f64) -> Option<[f64; 3]> {
        let (touches, work) = (self.touches(bodies, a)?, self.aim?);
        let mut merit = [0.0, 0.0, 0.0_f64];
        for ((row, touch), [slack, force]) in self.rows.iter().zip(touches).zip(&self.changes) {
            let at = (row.slack + part * slack).max(if part > 0.0 { touch.gap } else { 0.0 });
            merit[0] -= work * at.ln();
            merit[1] += (touch.gap - at).abs();
            merit[2] = merit[2].max(row.force).max(row.force + force);
        }
        Some(merit)
    }

    fn review(&mut self, bodies: &Bodies, a: &[f64], closest: Closest) -> Progress {
        let shapes = Self::shapes(bodies, a);
        let mut progress = Progress::default();
        let touches = self.each(bodies, a).clone();
        for (row, touch) in self.rows.iter_mut().zip(touches) {
            let Some(touch) = touch else { continue };
            (row.sample, row.against) = (touch.sample, touch.against);
            row.slack = row.slack.max(touch.gap);
            progress.violation = progress.violation.max(-touch.gap);
            progress.work += row.force * row.slack;
            progress.complementarity = progress.complementarity.max(row.force * touch.gap.abs());
            progress.rows += 1;
        }
        let largest = self.rows.iter().map(|r| r.force).fold(0.0, f64::max);
        let depth = self.between.depth();
        let small = |r: &Row| r.force < 1e-2 * largest && r.slack < 1e-3 * depth;
        progress.undecided = self.rows.iter().any(small);
        if closest != Closest::Nowhere {
            let depth = DIP * bodies.extent();
            let (added, deepest) = self.add_dips(bodies, &shapes, depth, closest == Closest::All);
            self.least = deepest.max(DIP * bodies.extent());
            progress.changed = added;
            progress.violation = progress.violation.max(deepest);
        }
        // Where a row is on its arc is part of what it finds.
        self.known = Known::default();
        progress
    }
}
