//! A half-plane in exact contact: rows are of what is near, a bound of the step keeps out the rest.

use nalgebra::Vector2;

use super::contact_row::Against;
use crate::bodies::Bodies;
use crate::constraint::separating_lines::{LEFT_OF_DISTANCE, first_fall};
use crate::constraint::shape::Shape;
use crate::solid::Cursor;

/// Solids out of `<x, normal> <= offset`, `x` about [`Bodies::origin`], looked at as near and as deep as `depth`.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::constraint) struct Wall {
    pub(in crate::constraint) depth: f64,
    pub(in crate::constraint) normal: Vector2<f64>,
    pub(in crate::constraint) offset: f64,
    /// Of every solid that keeps out, on its boundary.
    pub(in crate::constraint) samples: Vec<(usize, Cursor)>,
}

impl Wall {
    pub(in crate::constraint) fn against(&self) -> Against {
        Against::Plane {
            normal: self.normal,
            offset: self.offset,
        }
    }

    /// The solids that keep out, each once.
    pub(super) fn solids(&self) -> Vec<usize> {
        let mut solids: Vec<usize> = self.samples.iter().map(|(body, _)| *body).collect();
        solids.sort_unstable();
        solids.dedup();
        solids
    }

    /// The samples that are as near as the depth.
    pub(super) fn near<'a>(&'a self, shapes: &'a [Shape]) -> impl Iterator<Item = (usize, Cursor)> + 'a {
        let gap = |(body, cursor): &(usize, Cursor)| shapes[*body].place(cursor).dot(&self.normal) - self.offset;
        self.samples
            .iter()
            .copied()
            .filter(move |sample| gap(sample) < self.depth)
    }

    /// The part of a step, at most 1, after which no sample is deeper than the depth: those without a row go nowhere unseen.
    pub(in crate::constraint) fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let along = |arcs: Vec<[Vector2<f64>; 3]>| -> Vec<[f64; 3]> {
            arcs.iter().map(|arc| arc.map(|x| x.dot(&self.normal))).collect()
        };
        // Nodes are shared by the samples of an arc: once for each solid.
        let mut known: Vec<Option<[Vec<[f64; 3]>; 2]>> = vec![None; bodies.len()];
        for body in self.solids() {
            let (solid, part, moves) = (bodies.solid(body), bodies.part(body, a), bodies.part(body, step));
            known[body] = Some([
                along(solid.outline_about(part, bodies.origin())),
                along(solid.velocities(part, moves)),
            ]);
        }
        let mut most = 1.0_f64;
        for (body, cursor) in &self.samples {
            // Every sample's solid is among `solids`: the other case does not occur.
            let Some([heights, rates]) = &known[*body] else {
                continue;
            };
            let at = |nodes: &[[f64; 3]]| -> f64 {
                let values = nodes[cursor.arc].iter().zip(cursor.weights());
                values.map(|(value, weight)| value * weight).sum()
            };
            let (solid, moves) = (bodies.solid(*body), bodies.part(*body, step));
            let swerves = solid.boundary().arcs[cursor.arc].map(|n| solid.swerve(moves, n));
            // 0.625 is the largest sum of absolute weights of an arc's three nodes, halved: how far a turn swerves off the
            // straight way.
            let bend = 0.625 * swerves.into_iter().fold(0.0, f64::max);
            // Down to the depth, at which the next review gives a row to whatever has come through.
            let room = (1.0 - LEFT_OF_DISTANCE) * (at(heights) - self.offset + self.depth);
            most = most.min(first_fall(room, at(rates), bend));
        }
        most
    }
}
