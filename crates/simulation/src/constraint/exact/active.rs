//! Steps of the rows: what they aim at, how far a step may go, which rows there are.

use super::central_path::Aim;
use super::contact_row::{Against, Row};
use super::{Exact, GONE_DEPTHS, LOADED_ROW_GAP, SAME_ARC_PART};
use crate::bodies::Bodies;
use crate::constraint::shape::Shape;
use crate::constraint::{Active, Progress};
use crate::solid::Cursor;

/// A slack falls to this part of itself in one step at most; a force too.
// The fraction-to-the-boundary rule of interior methods (Nocedal and Wright 2006, 19.2) with 0.99.
const TO_BOUNDARY: f64 = 0.01;
/// Or to this part of what the aim is of force times slack now: an aim that falls faster must not be stopped by the rule.
const TO_BOUNDARY_OF_AIM: f64 = 0.1;
/// A slack begins anew at this part of the depth at most.
const MOST_RECENTRED_DEPTHS: f64 = 0.5;
/// A new row begins with this part of the largest force at most.
const FIRST_FORCE: f64 = 0.01;
/// Dips less deep than this part of the largest solid are none.
const LEAST_DIP_EXTENTS: f64 = 1e-13;

/// The part of a step by which a value falls to the part `left` of itself.
fn most(value: f64, by: f64, left: f64) -> f64 {
    if by < 0.0 { (left - 1.0) * value / by } else { 1.0 }
}

impl Active for Exact {
    fn aim(&mut self, work: Option<f64>) {
        let depth = self.between.depth();
        self.aim = work.map(|work| Aim { work, depth });
        let Some(aim) = self.aim else { return };
        let largest = self.rows.iter().map(|r| r.force).fold(0.0, f64::max);
        for row in &mut self.rows {
            if row.slack <= 0.0 || row.force <= 0.0 {
                // A new row, violated or without a force: with little of both, or it would throw all others off.
                let room = if largest > 0.0 {
                    aim.work / (FIRST_FORCE * largest)
                } else {
                    0.0
                };
                row.slack = row.slack.max(self.least.max(room).min(0.5 * depth));
                row.force = row.force.max(aim.force(row.slack));
            }
        }
    }

    fn recentre(&mut self, work: f64) {
        let depth = self.between.depth();
        let aim = Aim { work, depth };
        // Rows without a slack begin in `aim`.
        for row in self.rows.iter_mut().filter(|row| row.slack > 0.0) {
            if row.force > 0.0 {
                row.slack = row.slack.max((work / row.force).min(MOST_RECENTRED_DEPTHS * depth));
            }
            row.force = row.force.max(aim.force(row.slack));
        }
        // In corners what a row finds depends on its slack.
        self.known.forget();
    }

    fn limits(&mut self, bodies: &Bodies, a: &[f64], step: &[f64]) -> [f64; 2] {
        let mut parts = [1.0_f64; 2];
        let mut changes = std::mem::take(&mut self.changes);
        changes.clear();
        // A lost foot or no aim: without changes `take` leaves all rows as they are.
        let (Some(touches), Some(aim)) = (self.touches(bodies, a), self.aim) else {
            return parts;
        };
        for (row, touch) in self.rows.iter().zip(touches.iter()) {
            let Some(touch) = touch else {
                changes.push([0.0; 2]);
                continue;
            };
            let rows = touch.rows(bodies, a).0;
            let rate: f64 = rows.iter().map(|r| touch.normal.dot(&r.by) * step[r.unknown]).sum();
            // Gap and slack become equal in a whole step, whatever they were.
            let slack = rate + touch.gap - row.slack;
            let own = aim.of(row.force, LOADED_ROW_GAP * self.keep);
            let force = own.force(row.slack) - own.stiffness(row.force, row.slack) * slack - row.force;
            let left = TO_BOUNDARY.min(TO_BOUNDARY_OF_AIM * own.work / (row.force * row.slack));
            parts[0] = parts[0].min(most(row.slack, slack, left));
            // Far rows have the force of the aim, which follows the slack and needs no limit.
            if !aim.far(row.slack) {
                parts[1] = parts[1].min(most(row.force, force, left));
            }
            changes.push([slack, force]);
        }
        self.changes = changes;
        parts
    }

    fn take(&mut self, parts: [f64; 2]) {
        for (row, [slack, force]) in self.rows.iter_mut().zip(&self.changes) {
            row.slack += parts[0] * slack;
            row.force += parts[1] * force;
            if let Some(aim) = self.aim.filter(|aim| aim.far(row.slack)) {
                row.force = aim.force(row.slack);
            }
        }
    }

    fn merit(&self, bodies: &Bodies, a: &[f64], part: f64) -> Option<[f64; 3]> {
        let (touches, aim) = (self.touches(bodies, a)?, self.aim?);
        let mut merit = [0.0, 0.0, 0.0_f64];
        for ((row, touch), [slack, force]) in self.rows.iter().zip(touches.iter()).zip(&self.changes) {
            let Some(touch) = touch else { continue };
            // `review` lifts a slack to its gap after the step: the merit looks at the one that will be.
            let at = (row.slack + part * slack).max(if part > 0.0 { touch.gap } else { 0.0 });
            merit[0] += aim.energy(at);
            merit[1] += (touch.gap - at).abs();
            merit[2] = merit[2].max(row.force).max(row.force + force);
        }
        Some(merit)
    }

    fn review(&mut self, bodies: &Bodies, a: &[f64], between: bool) -> Progress {
        let shapes = Self::shapes(bodies, a);
        let largest = self.rows.iter().map(|r| r.force).fold(0.0, f64::max);
        let mut progress = Progress {
            largest,
            ..Progress::default()
        };
        let touches = self.each(bodies, a);
        let depth = self.between.depth();
        let whole = Aim { work: 1.0, depth };
        for (mut row, touch) in std::mem::take(&mut self.rows).into_iter().zip(touches.iter()) {
            let Some(touch) = touch.filter(|touch| touch.gap < GONE_DEPTHS * depth) else {
                continue;
            };
            (row.sample, row.against, row.normal) = (touch.sample, touch.against, touch.normal);
            // A slack above zero never falls here; one below its gap would only shorten the next step.
            row.slack = row.slack.max(touch.gap);
            progress.violation = progress.violation.max(-touch.gap);
            progress.work += row.force * row.slack;
            // Loaded rows keep about a thousandth of `keep` on purpose: that is no lack.
            let gap = (touch.gap.abs() - 10.0 * LOADED_ROW_GAP * self.keep).max(0.0);
            progress.complementarity = progress.complementarity.max(row.force * gap);
            progress.rows += whole.part(row.slack);
            progress.undecided |= row.force < 1e-2 * largest && row.slack < 1e-3 * depth;
            // Closest points that were two may have met.
            match self.rows.iter_mut().find(|r| row.slides && r.twin(&row)) {
                Some(twin) => twin.force += row.force,
                None => self.rows.push(row),
            }
        }
        self.add_near(bodies, &shapes);
        if between {
            let deepest = self.add_dips(bodies, &shapes, LEAST_DIP_EXTENTS * bodies.extent());
            self.least = deepest.max(LEAST_DIP_EXTENTS * bodies.extent());
            progress.violation = progress.violation.max(deepest);
        }
        // Where a row is on its arc is part of what it finds.
        self.known.forget();
        progress
    }
}

impl Exact {
    /// Adds points where arcs are closest, deeper in one another than the rows let them; the deepest.
    fn add_dips(&mut self, bodies: &Bodies, shapes: &[Shape], depth: f64) -> f64 {
        let (rows, mut deepest) = (&mut self.rows, 0.0_f64);
        let mut dip = |body: usize, sample: Cursor, against: Against, gap: f64| {
            if gap >= 0.0 {
                return;
            }
            deepest = deepest.max(-gap);
            let place = shapes[body].place(&sample);
            let size = (shapes[body].arcs[sample.arc][2] - shapes[body].arcs[sample.arc][0]).norm();
            // A row that slides may be there already, from the round before.
            let same = |r: &Row| {
                let near = (shapes[r.body].place(&r.sample) - place).norm() < SAME_ARC_PART * size;
                near && r.body == body && r.against.arc() == against.arc()
            };
            if gap < -depth && !rows.iter().any(same) {
                rows.push(Row {
                    slides: true,
                    ..Row::new(body, sample, against, 0.0)
                });
            }
        };
        self.between
            .dips(bodies, shapes, 0.0, true, &mut |[body, other], sample, foot| {
                dip(body, sample, Against::Arc { other, foot: foot.on }, foot.gap);
            });
        self.between.lowest(bodies, shapes, &mut |body, sample, against, gap| {
            dip(body, sample, against, gap)
        });
        deepest
    }
}
