//! One row: a point that keeps out of something.

use nalgebra::Vector2;

use super::SAME_ARC_PART;
use super::closest_points::Dip;
use crate::bodies::Bodies;
use crate::constraint::rows::{Rows, bend};
use crate::constraint::shape::Shape;
use crate::constraint::signed::{Foot, Moves, walk};
use crate::solid::Cursor;
use crate::sparse::Triplets;

/// In a corner that goes in, both sides count that differ by so many slacks at most.
const CORNER_SLACKS: f64 = 1.0;

/// What a point keeps out of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::constraint) enum Against {
    /// The inner side of another boundary, near a foot on it.
    Arc { other: usize, foot: Cursor },
    /// `<x, normal> <= offset`.
    Plane { normal: Vector2<f64>, offset: f64 },
}

impl Against {
    /// The other solid and its arc, if it is one.
    pub(super) fn arc(&self) -> Option<[usize; 2]> {
        match self {
            Self::Arc { other, foot } => Some([*other, foot.arc]),
            Self::Plane { .. } => None,
        }
    }
}

/// A row with what it remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub(super) body: usize,
    pub(super) sample: Cursor,
    pub(super) against: Against,
    pub(super) force: f64,
    pub(super) slack: f64,
    /// A closest point of two arcs, which slides with them.
    pub(super) slides: bool,
    /// The direction in which it was last pushed.
    pub(super) normal: Vector2<f64>,
}

/// A row in one state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    body: usize,
    /// Where it is now, if it slides.
    pub(super) sample: Cursor,
    /// With the foot where it is now.
    pub(super) against: Against,
    pub(super) gap: f64,
    pub(super) normal: Vector2<f64>,
    foot: Option<Foot>,
    dip: Option<Dip>,
}

impl Row {
    /// A row that stays where it is on its solid; its slack is still to be found.
    pub(super) fn new(body: usize, sample: Cursor, against: Against, force: f64) -> Self {
        Self {
            body,
            sample,
            against,
            force,
            slack: 0.0,
            slides: false,
            normal: Vector2::zeros(),
        }
    }

    /// True where a touch of the same sample is that of this row: the same place on the other solid, pushed the same way.
    pub(super) fn same(&self, touch: &Touch, shapes: &[Shape]) -> bool {
        let (Against::Arc { other, foot }, Against::Arc { other: o, foot: f }) = (self.against, touch.against) else {
            return self.against.arc() == touch.against.arc();
        };
        if other != o || self.normal.dot(&touch.normal) < 1.0 - SAME_ARC_PART {
            return false;
        }
        let (shape, nodes) = (&shapes[other], &shapes[other].arcs[foot.arc]);
        (shape.place(&foot) - shape.place(&f)).norm() < SAME_ARC_PART * (nodes[2] - nodes[0]).norm()
    }

    /// True for a closest point that is the same as this one.
    pub(super) fn twin(&self, other: &Self) -> bool {
        let same = self.body == other.body && self.sample.arc == other.sample.arc;
        same && self.slides
            && self.against.arc() == other.against.arc()
            && (self.sample.u - other.sample.u).abs() < SAME_ARC_PART
    }

    /// Where it is now. `None` where it has lost its foot.
    pub(super) fn touch(&self, bodies: &Bodies, shapes: &[Shape]) -> Option<Touch> {
        let point = shapes[self.body].place(&self.sample);
        let (body, sample) = (self.body, self.sample);
        Some(match self.against {
            Against::Plane { normal, offset } => {
                let lowest = self
                    .slides
                    .then(|| Dip::lowest(&shapes[body], sample, normal))
                    .flatten();
                let (sample, dip) = lowest.map_or((sample, None), |(sample, dip)| (sample, Some(dip)));
                Touch {
                    body,
                    sample,
                    against: self.against,
                    gap: shapes[body].place(&sample).dot(&normal) - offset,
                    normal,
                    foot: None,
                    dip,
                }
            }
            Against::Arc { other, foot } => {
                let slides = self
                    .slides
                    .then(|| Dip::follow(&shapes[body], &shapes[other], sample, foot))
                    .flatten();
                // A closest point that has flattened out, or left its arcs, stays where it was.
                let (sample, foot, dip) = match slides {
                    Some((sample, foot, dip)) => (sample, foot, Some(dip)),
                    None => (
                        sample,
                        walk(
                            &shapes[other],
                            bodies.solid(other).boundary(),
                            foot,
                            point,
                            CORNER_SLACKS * self.slack,
                        )?,
                        None,
                    ),
                };
                Touch {
                    body,
                    sample,
                    against: Against::Arc { other, foot: foot.on },
                    gap: foot.gap,
                    normal: foot.normal,
                    foot: Some(foot),
                    dip,
                }
            }
        })
    }
}

impl Touch {
    /// Derivatives of the point against its foot; `slope` is that of the foot's arc, with a minus.
    pub(super) fn rows(&self, bodies: &Bodies, a: &[f64]) -> Rows {
        self.rows_and_slopes(bodies, a).0
    }

    /// And of the slope of the sample's arc, for the unknowns of the sample.
    fn rows_and_slopes(&self, bodies: &Bodies, a: &[f64]) -> (Rows, Vec<Vector2<f64>>) {
        let mut rows = Rows::default();
        rows.add(bodies, self.body, &self.sample, a, 1.0);
        let slopes = rows.0.iter().map(|r| r.slope).collect();
        if let Against::Arc { other, foot } = self.against {
            // The slope of the sample's arc counts only where the sample slides, and is kept apart.
            rows.0.iter_mut().for_each(|r| r.slope = Vector2::zeros());
            rows.add(bodies, other, &foot, a, -1.0);
        }
        (rows, slopes)
    }

    /// Adds `stiffness dg dg^T - force d2 g`, or the first alone where `convex`.
    pub(super) fn add_second(
        &self,
        bodies: &Bodies,
        a: &[f64],
        stiffness: f64,
        force: f64,
        convex: bool,
        sink: &mut Triplets,
    ) {
        let ((rows, slopes), normal) = (self.rows_and_slopes(bodies, a), self.normal);
        let moves: Vec<Moves> = rows
            .0
            .iter()
            .map(|r| Moves {
                by: r.by,
                slope: -r.slope,
            })
            .collect();
        let steep: Vec<f64> = moves.iter().map(|m| normal.dot(&m.by)).collect();
        let mixed = |k: usize| {
            // The sample's unknowns come first and have the same numbers; those of the other solid have no such slope.
            let slope = slopes.get(k).copied().unwrap_or_default();
            match (&self.dip, &self.foot) {
                (Some(dip), Some(foot)) => dip.mixed(foot, &moves[k], slope),
                (Some(_), None) => normal.dot(&slope),
                _ => 0.0,
            }
        };
        let mixed: Vec<f64> = (0..moves.len()).map(mixed).collect();
        // A point that slides follows the least distance: its own motion takes part of the curvature out.
        let curved = self.dip.map_or(0.0, |dip| 1.0 / dip.second);
        for (i, p) in rows.0.iter().enumerate() {
            for (j, q) in rows.0[..=i].iter().enumerate() {
                let mut value = stiffness * steep[i] * steep[j];
                if !convex {
                    // A plane has no foot and no curvature.
                    let bent = self.foot.as_ref().map_or(0.0, |foot| foot.second(&moves[i], &moves[j]));
                    value -= force * (bent - mixed[i] * mixed[j] * curved);
                }
                sink.add(p.unknown, q.unknown, value);
            }
        }
        if !convex {
            bend(bodies, self.body, &self.sample, a, normal * -force, sink);
            if let Against::Arc { other, foot } = &self.against {
                bend(bodies, *other, foot, a, normal * force, sink);
            }
        }
    }
}
