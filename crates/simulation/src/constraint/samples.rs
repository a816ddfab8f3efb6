//! Samples of each boundary near the arcs of the others.

use std::cell::Cell;

use nalgebra::Vector2;

use super::broad_phase::{Place, near_arcs};
use super::collision_pairs::Meeting;
use super::near::{Near, outside_own};
use super::nearest::nearest;
use super::shape::{Shape, beside, box_distance, boxes_near};
use crate::bodies::Bodies;
use crate::q9::shape::line_slope;
use crate::solid::Cursor;

/// Samples of each arc, at least and at most; the first lies on its first node.
const MIN_SAMPLES: u32 = 4;
const MAX_SAMPLES: u32 = 64;

/// Which samples are looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples<'a> {
    pub(super) meeting: &'a Meeting,
    /// The width of the barrier: how close samples lie.
    pub(super) width: f64,
}

impl Samples<'_> {
    /// Calls `visit` with every sample that comes as near as `within` to an arc of another solid. The visitor may narrow it.
    pub(super) fn visit(&self, bodies: &Bodies, shapes: &[Shape], within: &Cell<f64>, visit: &mut dyn FnMut(Near)) {
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
        // Boxes first: most arcs that a search along one axis finds are apart along the other.
        let count = self.count(bodies, first, arc);
        let part = 2.0 / f64::from(count);
        for k in 0..count {
            let u = f64::from(k) * part - 1.0;
            let sample = Cursor { arc, u };
            let point = shape.place(&sample);
            if box_distance(bounds, &point) >= within.get() || beside(nodes, &point, within.get()) {
                continue;
            }
            let at = nearest(nodes, point);
            // On its own boundary a sample has neighbours that it must not push from.
            let own_kind = first == second && !outside_own(bodies, first, nodes, [arc, against], &at);
            if at.distance < within.get() && !own_kind {
                // By the reference arc: the length that a sample stands for, and so the energy's scale, must not depend
                // on the state.
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

    /// Samples of an arc: so many that between them, on two arcs of its bend, the distance changes by less than the width.
    ///
    /// An arc that departs by `s` from its chord departs by `s / n^2` from the chords of `n` pieces.
    pub(super) fn count(&self, bodies: &Bodies, body: usize, arc: usize) -> u32 {
        let boundary = bodies.solid(body).boundary();
        let [a, b, c] = boundary.reference[arc];
        let depth = (b - (a + c) * 0.5).norm();
        let wanted = (3.0 * (depth / self.width).sqrt()).ceil();
        // The bound before the cast: a width of zero asks for infinitely many.
        (wanted.min(f64::from(MAX_SAMPLES)) as u32).max(MIN_SAMPLES)
    }
}

/// Reference length by parameter at a sample.
fn reference_speed(bodies: &Bodies, body: usize, sample: &Cursor) -> f64 {
    let reference = &bodies.solid(body).boundary().reference[sample.arc];
    let speed: Vector2<f64> = reference.iter().zip(line_slope(sample.u)).map(|(r, s)| r * s).sum();
    speed.norm()
}
