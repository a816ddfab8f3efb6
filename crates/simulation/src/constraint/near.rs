//! A sample near an arc: the rows of their distance and its second derivative.

use nalgebra::Vector2;

use super::nearest::Nearest;
use super::rows::{Row, Rows};
use crate::bodies::Bodies;
use crate::q9::shape::line_slope;
use crate::solid::Cursor;
use crate::sparse::Triplets;

/// A sample near an arc of another solid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub(super) on: [usize; 2],
    pub(super) sample: Cursor,
    pub(super) foot: Cursor,
    pub(super) length: f64,
    pub(super) at: Nearest,
}

/// True where an arc is none of a sample's own or next to it, and has the sample on its outer side.
pub(super) fn outside_own(
    bodies: &Bodies,
    body: usize,
    nodes: &[Vector2<f64>; 3],
    [arc, other]: [usize; 2],
    at: &Nearest,
) -> bool {
    let boundary = bodies.solid(body).boundary();
    let apart = arc != other && boundary.next[arc] != other && boundary.previous[arc] != other;
    let slope: Vector2<f64> = nodes.iter().zip(line_slope(at.u)).map(|(p, s)| p * s).sum();
    // The outward normal is `(q'_y, -q'_x)`: an arc seen through the solid's inside does not push.
    apart && slope.y * at.offset.x - slope.x * at.offset.y > 0.0
}

impl Near {
    pub(super) fn rows(&self, bodies: &Bodies, a: &[f64]) -> Rows {
        let mut rows = Rows::default();
        rows.add(bodies, self.on[0], &self.sample, a, 1.0);
        // The sample's own slope plays no part: it does not slide along its arc.
        rows.0.iter_mut().for_each(|row| row.slope = Vector2::zeros());
        rows.add(bodies, self.on[1], &self.foot, a, -1.0);
        rows
    }

    /// Unit vector from the foot to the sample.
    pub(super) fn direction(&self) -> Vector2<f64> {
        self.at.offset / self.at.distance
    }

    /// Adds `second d^2 + first d2 h`, where `d` is the derivative of the distance `h` and `d2 h` its second: with `f(a, u)` the
    /// distance to the point `u` of the arc that is `f_aa - f_au f_ua / f_uu` where the foot slides, `f_aa` where it sits at
    /// an end.
    pub(super) fn add_second(
        &self,
        rows: &Rows,
        arc: &[Vector2<f64>; 3],
        [first, second]: [f64; 2],
        sink: &mut Triplets,
    ) {
        let (e, d) = (self.direction(), self.at.distance);
        let slope: Vector2<f64> = arc.iter().zip(line_slope(self.foot.u)).map(|(p, s)| p * s).sum();
        let bend = arc[0] - arc[1] * 2.0 + arc[2];
        let across = slope - e * e.dot(&slope);
        // `f_uu = (|q'|^2 - (e . q')^2) / d - e . q''`.
        let along = across.norm_squared() / d - e.dot(&bend);
        // A foot that is not a strict minimum along its arc does not follow: the quotient would be without bound.
        let slides = if self.at.inside && along > 0.0 {
            first / along
        } else {
            0.0
        };
        // The second derivative by the point alone is `(I - e e^T) / d`.
        let flat = first / d;
        // f_u = -e . q'; its derivative by an unknown: rows hold the arc's part with its sign.
        let mixed = |r: &Row| e.dot(&r.slope) - across.dot(&r.by) / d;
        let of = |r: &Row| (e.dot(&r.by), mixed(r), r.by);
        rows.add_form_of(sink, of, |p, q| {
            (second - flat) * p.0 * q.0 + flat * p.2.dot(&q.2) - slides * p.1 * q.1
        });
    }
}

/// A sample as exact contact sees it: with a sign, from the outer side of the arc where it has a foot inside it.
pub(super) fn signed(arc: &[Vector2<f64>; 3], at: &Nearest) -> (Vector2<f64>, f64) {
    let slope: Vector2<f64> = arc.iter().zip(line_slope(at.u)).map(|(p, s)| p * s).sum();
    let normal = Vector2::new(slope.y, -slope.x).try_normalize(0.0).unwrap_or_default();
    if at.inside {
        (normal, normal.dot(&at.offset))
    } else {
        (at.offset / at.distance, at.distance)
    }
}
