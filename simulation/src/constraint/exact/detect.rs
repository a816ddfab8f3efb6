//! Where boundaries come closest between the rows.

use nalgebra::Vector2;

use super::dip::Dip;
use super::row::Against;
use crate::constraint::shape::{Shape, boxes_near};
use crate::constraint::signed::Foot;
use crate::solid::Cursor;
use crate::system::Bodies;

/// What keeps out of what.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::constraint) enum Between {
    /// Solids out of one another, some (`own`) out of themselves, looked at as deep as `depth`.
    Solids { depth: f64, own: Vec<usize> },
    /// These solids out of a half-plane.
    Plane {
        depth: f64,
        which: Vec<usize>,
        normal: Vector2<f64>,
        offset: f64,
    },
}

impl Between {
    /// How deep is looked.
    pub(super) fn depth(&self) -> f64 {
        match self {
            Self::Solids { depth, .. } | Self::Plane { depth, .. } => *depth,
        }
    }

    /// Calls `visit` with the closest points of every two arcs whose boxes come as near as `within`, where they lie between
    /// nodes.
    pub(super) fn dips(
        &self,
        bodies: &Bodies,
        shapes: &[Shape],
        within: f64,
        visit: &mut dyn FnMut([usize; 2], Cursor, Foot),
    ) {
        let Self::Solids { depth, own } = self else { return };
        let pairs = (0..shapes.len()).flat_map(|i| (i..shapes.len()).map(move |j| [i, j]));
        for [first, second] in pairs.filter(|[i, j]| i != j || own.contains(i)) {
            let (one, other) = (&shapes[first], &shapes[second]);
            if !boxes_near(&one.bounds, &other.bounds, within) {
                continue;
            }
            for arc in (0..one.arcs.len()).filter(|arc| boxes_near(&one.boxes[*arc], &other.bounds, within)) {
                for against in (0..other.arcs.len()).filter(|k| boxes_near(&one.boxes[arc], &other.boxes[*k], within)) {
                    let same = first == second && (against <= arc || neighbours(bodies, first, arc, against));
                    if same {
                        continue;
                    }
                    let near = Dip::all(one, arc, other, against).into_iter();
                    near.filter(|(_, foot)| foot.gap.abs() < *depth)
                        .for_each(|(sample, foot)| visit([first, second], sample, foot));
                }
            }
        }
    }

    /// Calls `visit` with the lowest point of every arc over a half-plane, where it lies between nodes.
    pub(super) fn lowest(&self, bodies: &Bodies, shapes: &[Shape], visit: &mut dyn FnMut(usize, Cursor, Against, f64)) {
        let Self::Plane {
            which, normal, offset, ..
        } = self
        else {
            return;
        };
        for &body in which.iter().filter(|b| !bodies.solid(**b).boundary().straight) {
            for (arc, nodes) in shapes[body].arcs.iter().enumerate() {
                let [low, middle, high] = nodes.map(|x| x.dot(normal) - offset);
                let (slope, bend) = (0.5 * (high - low), high + low - 2.0 * middle);
                if bend > 0.0 && slope.abs() < bend {
                    let sample = Cursor { arc, u: -slope / bend };
                    let against = Against::Plane {
                        normal: *normal,
                        offset: *offset,
                    };
                    visit(body, sample, against, middle - 0.5 * slope * slope / bend);
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
