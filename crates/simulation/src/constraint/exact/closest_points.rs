//! Closest points of two arcs between their nodes.
//!
//! With `h(u, a)` the signed distance of the point `u` of one arc to the other, the least over `u` has the derivatives
//! `h_a` and `h_aa - h_au h_ua / h_uu`.

use nalgebra::Vector2;

use crate::constraint::nearest::{combine, nearest};
use crate::constraint::shape::Shape;
use crate::constraint::signed::{Foot, Moves};
use crate::q9::shape::{line, line_slope};
use crate::solid::Cursor;

/// Places tried on an arc.
const PLACES_PER_ARC: u32 = 8;
/// Steps of the search for one that is not sharp: each leaves two thirds.
const MAX_TERNARY_STEPS: usize = 24;
/// A closest point is one where the distance bends by this part of its arc's half length.
const SHARP_BEND: f64 = 0.02;

/// After a step as short as this the next one is rounding, however little the distance bends.
const LAST_STEP: f64 = 1e-8;

/// How the distance changes along the arc of the sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dip {
    along: Vector2<f64>,
    /// `h_uu`.
    pub(super) second: f64,
}

impl Dip {
    /// At a sample with its foot; also `h_u`.
    fn at(nodes: &[Vector2<f64>; 3], u: f64, foot: &Foot) -> (Self, f64) {
        let along = combine(nodes, line_slope(u));
        let bend = nodes[0] - nodes[1] * 2.0 + nodes[2];
        let unit = Moves {
            by: along,
            slope: Vector2::zeros(),
        };
        let second = foot.second(&unit, &unit) + foot.normal.dot(&bend);
        (Self { along, second }, foot.normal.dot(&along))
    }

    /// `h_ua` of an unknown that moves the sample against the foot by `moves`, and the slope of its arc by `slope`.
    pub(super) fn mixed(&self, foot: &Foot, moves: &Moves, slope: Vector2<f64>) -> f64 {
        let unit = Moves {
            by: self.along,
            slope: Vector2::zeros(),
        };
        foot.second(&unit, moves) + foot.normal.dot(&slope)
    }

    /// True where the closest point is one, and not a stretch that runs along the other arc.
    fn sharp(&self) -> bool {
        self.second > SHARP_BEND * self.along.norm()
    }

    /// The closest point near a sample, on the same two arcs. `None` where it runs out of them, or there is none.
    pub(super) fn follow(own: &Shape, other: &Shape, sample: Cursor, foot: Cursor) -> Option<(Cursor, Foot, Self)> {
        let (nodes, against) = (&own.arcs[sample.arc], &other.arcs[foot.arc]);
        let (mut u, mut settled) = (sample.u, false);
        for _ in 0..30 {
            let near = nearest(against, combine(nodes, line(u)));
            // At an end of the other arc the node's own sample keeps out.
            if !near.inside {
                return None;
            }
            let foot = Foot::inside(foot.arc, against, combine(nodes, line(u)), near.u)?;
            let (dip, slope) = Self::at(nodes, u, &foot);
            if !dip.sharp() {
                return None;
            }
            if settled {
                return Some((Cursor { arc: sample.arc, u }, foot, dip));
            }
            let step = slope / dip.second;
            settled = step.abs() <= LAST_STEP;
            // A quarter of the arc at most: the curvature that the step is made with is that of one place.
            u = (u - step.clamp(-0.5, 0.5)).clamp(-1.0, 1.0);
            if u.abs() >= 1.0 {
                return None;
            }
        }
        None
    }

    /// The lowest point of an arc along a direction. `None` where it lies at an end, or the arc is too flat to have one.
    pub(super) fn lowest(own: &Shape, sample: Cursor, normal: Vector2<f64>) -> Option<(Cursor, Self)> {
        let nodes = &own.arcs[sample.arc];
        let heights = nodes.map(|x| x.dot(&normal));
        let second = heights[2] + heights[0] - 2.0 * heights[1];
        let u = -0.5 * (heights[2] - heights[0]) / second;
        let along = combine(nodes, line_slope(u));
        let dip = Self { along, second };
        (u.abs() < 1.0 && dip.sharp()).then_some((Cursor { arc: sample.arc, u }, dip))
    }

    /// All closest points of two arcs between nodes. With `flat`, where arcs run along one another too, and at nodes.
    pub(super) fn all(own: &Shape, arc: usize, other: &Shape, against: usize, flat: bool) -> Vec<(Cursor, Foot)> {
        let place = |k: u32| f64::from(k) * 2.0 / f64::from(PLACES_PER_ARC) - 1.0;
        let gaps: Vec<f64> = (0..=PLACES_PER_ARC)
            .map(|k| foot_at(own, arc, other, against, place(k)).map_or(f64::INFINITY, |f| f.gap))
            .collect();
        let lowest = (0..gaps.len()).filter(|&k| {
            // At an end a place is its own neighbour: ends count as lowest where the one neighbour is not lower.
            let (before, after) = (k.saturating_sub(1), (k + 1).min(gaps.len() - 1));
            gaps[k].is_finite() && gaps[k] <= gaps[before] && gaps[k] <= gaps[after]
        });
        let found = lowest.filter_map(|k| {
            let u = place(k as u32);
            let start = Cursor { arc, u };
            let sharp = Self::follow(own, other, start, Cursor { arc: against, u: 0.0 });
            let between = |(sample, foot): &(Cursor, Foot)| sample.u.abs() < 1.0 && foot.on.u.abs() < 1.0;
            let sharp = sharp.map(|(sample, foot, _)| (sample, foot)).filter(between);
            sharp.or_else(|| flat.then(|| lowest_near(own, arc, other, against, u)).flatten())
        });
        found.collect()
    }
}

/// The foot of a point of an arc inside another.
fn foot_at(own: &Shape, arc: usize, other: &Shape, against: usize, u: f64) -> Option<Foot> {
    let (point, nodes) = (combine(&own.arcs[arc], line(u)), &other.arcs[against]);
    let near = nearest(nodes, point);
    near.inside
        .then(|| Foot::inside(against, nodes, point, near.u))
        .flatten()
}

/// The least distance within a place's neighbours, by thirds: where it hardly changes, any place near will do.
fn lowest_near(own: &Shape, arc: usize, other: &Shape, against: usize, u: f64) -> Option<(Cursor, Foot)> {
    // Thirds need no second derivative, which vanishes where arcs run along one another.
    let step = 2.0 / f64::from(PLACES_PER_ARC);
    let gap = |u: f64| foot_at(own, arc, other, against, u).map_or(f64::INFINITY, |f| f.gap);
    let [mut low, mut high] = [(u - step).max(-1.0), (u + step).min(1.0)];
    for _ in 0..MAX_TERNARY_STEPS {
        let [first, second] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if gap(first) <= gap(second) {
            high = second;
        } else {
            low = first;
        }
    }
    let u = [low, high, u].into_iter().min_by(|a, b| gap(*a).total_cmp(&gap(*b)))?;
    Some((Cursor { arc, u }, foot_at(own, arc, other, against, u)?))
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation2;

    use super::*;

    /// A shallow arc over a straight one, turned and far from the origin: the closest point is found from every start. It was not where
    /// the rounding of the slope, over the little that the distance bends, was more than the last bits of the place.
    #[test]
    fn a_shallow_dip_is_found_from_every_start() {
        for k in 0..200 {
            let t = f64::from(k);
            let (turn, far) = (Rotation2::new(0.1 * t), Vector2::new(37.1 + t, 41.3 - 0.3 * t));
            let place = |points: [(f64, f64); 3]| points.map(|(x, y)| turn * Vector2::new(x, y) + far);
            // Lowest at 0.3; the distance bends by 0.03 of the half length. The solid below lies on the left of its arc.
            let height = |x: f64| 1e-6 + 0.015 * (x - 0.3) * (x - 0.3);
            let above = Shape::of_arcs(vec![place([-1.0, 0.0, 1.0].map(|x| (x, height(x))))]);
            let below = Shape::of_arcs(vec![place([(4.0, 0.0), (0.0, 0.0), (-4.0, 0.0)])]);
            let start = Cursor {
                arc: 0,
                u: 0.9 * (0.7 * t).sin(),
            };
            let found = Dip::follow(&above, &below, start, Cursor { arc: 0, u: 0.0 });
            let (sample, foot, _) = found.unwrap_or_else(|| panic!("{k}: none"));
            // Rounding of places of size 240 over the bend.
            let rounding = 240.0 * f64::EPSILON / 0.03;
            assert!((sample.u - 0.3).abs() <= 4.0 * rounding, "{k}: {}", sample.u);
            assert!((foot.gap - 1e-6).abs() <= 1e-12, "{k}: {}", foot.gap);
        }
    }
}
