//! Where boundaries come closest between the rows.

use std::cell::Cell;

use super::closest_points::Dip;
use super::contact_row::Against;
use super::wall::Wall;
use crate::bodies::Bodies;
use crate::constraint::broad_phase::near_arcs;
use crate::constraint::collision_pairs::Meeting;
use crate::constraint::samples::Samples;
use crate::constraint::shape::Shape;
use crate::constraint::signed::Foot;
use crate::solid::Cursor;

/// What keeps out of what.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::constraint) enum Between {
    /// Solids out of one another, after a barrier of this width.
    Solids { width: f64, meeting: Meeting },
    /// Solids out of a half-plane.
    Plane(Wall),
}

impl Between {
    /// How near and how deep is looked.
    pub(in crate::constraint) fn depth(&self) -> f64 {
        match self {
            Self::Solids { width, .. } => 2.0 * width,
            Self::Plane(wall) => wall.depth,
        }
    }

    /// Calls `visit` with every sample that is as near as the depth to what it keeps out of: `(solid, sample, against)`.
    pub(super) fn samples(&self, bodies: &Bodies, shapes: &[Shape], visit: &mut dyn FnMut(usize, Cursor, Against)) {
        match self {
            Self::Solids { width, meeting } => {
                let samples = Samples { meeting, width: *width };
                samples.visit(bodies, shapes, &Cell::new(self.depth()), &mut |near| {
                    let [body, other] = near.on;
                    visit(body, near.sample, Against::Arc { other, foot: near.foot });
                });
            }
            Self::Plane(wall) => wall
                .near(shapes)
                .for_each(|(body, sample)| visit(body, sample, wall.against())),
        }
    }

    /// Calls `visit` with the closest points of every two arcs whose boxes come as near as `within`, where they lie between
    /// nodes; with `flat`, where they run along one another too.
    pub(super) fn dips(
        &self,
        bodies: &Bodies,
        shapes: &[Shape],
        within: f64,
        flat: bool,
        visit: &mut dyn FnMut([usize; 2], Cursor, Foot),
    ) {
        let Self::Solids { meeting, .. } = self else { return };
        for mut pair in near_arcs(shapes, within) {
            // A closest point slides on the first arc: with the pair in one order it is the same row from state to
            // state.
            pair.sort_unstable();
            let [[first, arc], [second, against]] = pair.map(|place| place.map(|k| k as usize));
            // Arcs that share a node are closest there for ever.
            if !meeting.of(first, second) || first == second && neighbours(bodies, first, arc, against) {
                continue;
            }
            let near = Dip::all(&shapes[first], arc, &shapes[second], against, flat).into_iter();
            near.filter(|(_, foot)| foot.gap.abs() < self.depth())
                .for_each(|(sample, foot)| visit([first, second], sample, foot));
        }
    }

    /// Calls `visit` with the lowest point of every arc over a half-plane, where it lies between nodes.
    pub(super) fn lowest(&self, bodies: &Bodies, shapes: &[Shape], visit: &mut dyn FnMut(usize, Cursor, Against, f64)) {
        let Self::Plane(wall) = self else { return };
        let curved = |body: &usize| !bodies.solid(*body).boundary().straight;
        for body in wall.solids().into_iter().filter(curved) {
            for (arc, nodes) in shapes[body].arcs.iter().enumerate() {
                let [low, middle, high] = nodes.map(|x| x.dot(&wall.normal) - wall.offset);
                let (slope, bend) = (0.5 * (high - low), high + low - 2.0 * middle);
                // The parabola `middle + slope u + bend u^2 / 2` is least at `-slope / bend`, inside where that is
                // below 1.
                if bend > 0.0 && slope.abs() < bend {
                    let sample = Cursor { arc, u: -slope / bend };
                    let lowest = middle - 0.5 * slope * slope / bend;
                    visit(body, sample, wall.against(), lowest);
                }
            }
        }
    }
}

/// True for the same arc and for arcs that share a node.
fn neighbours(bodies: &Bodies, body: usize, arc: usize, other: usize) -> bool {
    let boundary = bodies.solid(body).boundary();
    arc == other || boundary.next[arc] == other || boundary.previous[arc] == other
}
