//! Boundaries in one state: positions of all nodes, boxes of arcs, samples.

use nalgebra::Vector2;

use crate::bodies::Bodies;
use crate::solid::Cursor;

/// Positions of the nodes of one boundary, by arc, about [`Bodies::origin`].
#[derive(Debug, Clone)]
pub(super) struct Shape {
    pub(super) arcs: Vec<[Vector2<f64>; 3]>,
    /// Boxes of the arcs: `[low, high]`.
    pub(super) boxes: Vec<[Vector2<f64>; 2]>,
    /// The box round all.
    pub(super) bounds: [Vector2<f64>; 2],
}

/// A box round a quadratic arc: it lies in the triangle of its ends and its control point.
fn bounds(arc: &[Vector2<f64>; 3]) -> [Vector2<f64>; 2] {
    let control = arc[1] * 2.0 - (arc[0] + arc[2]) * 0.5;
    [arc[0].inf(&arc[2]).inf(&control), arc[0].sup(&arc[2]).sup(&control)]
}

impl Shape {
    pub(super) fn of(bodies: &Bodies, body: usize, a: &[f64]) -> Self {
        let (solid, part) = (bodies.solid(body), bodies.part(body, a));
        Self::of_arcs(solid.outline_about(part, bodies.origin()))
    }

    /// Of arcs where they are.
    pub(super) fn of_arcs(arcs: Vec<[Vector2<f64>; 3]>) -> Self {
        let boxes: Vec<_> = arcs.iter().map(bounds).collect();
        let infinity = Vector2::repeat(f64::INFINITY);
        let bounds = boxes
            .iter()
            .fold([infinity, -infinity], |b, x| [b[0].inf(&x[0]), b[1].sup(&x[1])]);
        Self { arcs, boxes, bounds }
    }

    /// After the time `t` at these velocities of the nodes.
    pub(super) fn moved(&self, velocities: &[[Vector2<f64>; 3]], t: f64) -> Self {
        let each = self.arcs.iter().zip(velocities);
        Self::of_arcs(
            each.map(|(arc, v)| std::array::from_fn(|k| arc[k] + v[k] * t))
                .collect(),
        )
    }

    pub(super) fn place(&self, cursor: &Cursor) -> Vector2<f64> {
        let (arc, w) = (&self.arcs[cursor.arc], cursor.weights());
        arc[0] * w[0] + arc[1] * w[1] + arc[2] * w[2]
    }
}

/// A lower bound of the distance of a point to a box.
pub(super) fn box_distance([low, high]: &[Vector2<f64>; 2], point: &Vector2<f64>) -> f64 {
    let outside = (low - point).sup(&(point - high)).sup(&Vector2::zeros());
    outside.norm()
}

/// True where a point is farther than `within` from the strip along an arc's chord that holds the arc: that tells more of a slanted
/// arc than its box does.
pub(super) fn beside(arc: &[Vector2<f64>; 3], point: &Vector2<f64>, within: f64) -> bool {
    let chord = arc[2] - arc[0];
    let height = |x: Vector2<f64>| chord.x * x.y - chord.y * x.x;
    // The control point lies twice as high over the chord as the middle node.
    let (over, bulge) = (height(point - arc[0]), 2.0 * height(arc[1] - arc[0]));
    let outside = (over - bulge.max(0.0)).max(bulge.min(0.0) - over);
    // Heights are times the length of the chord, hence its square on the other side.
    outside > 0.0 && outside * outside > within * within * chord.norm_squared()
}

/// True where two boxes come closer than `within` along both axes.
pub(super) fn boxes_near(a: &[Vector2<f64>; 2], b: &[Vector2<f64>; 2], within: f64) -> bool {
    let gap = (a[0] - b[1]).sup(&(b[0] - a[1]));
    gap.max() <= within
}
