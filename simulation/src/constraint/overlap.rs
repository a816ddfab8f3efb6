//! Solids that overlap at the start.

use nalgebra::Vector2;

use super::nearest::{combine, nearest};
use super::shape::{Shape, box_distance, boxes_near};
use crate::q9::shape::line_slope;
use crate::solid::{Boundary, Cursor};
use crate::system::Bodies;

/// Two solids that overlap.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "solids {first} and {second} overlap by {depth:.3e} at ({x:.6}, {y:.6}): move one of them away before the start"
)]
pub struct Overlap {
    /// A solid.
    pub first: usize,
    /// Another.
    pub second: usize,
    /// Where a point of the first lies in the second.
    pub x: f64,
    /// Where a point of the first lies in the second.
    pub y: f64,
    /// How deep.
    pub depth: f64,
}

/// Points of each arc that stand for it.
const PIECES: u32 = 8;
/// A corner that turns by less than this angle is none.
const SMOOTH: f64 = 1e-9;

/// Pairs of solids of which one has a sampled point of its boundary inside the other.
///
/// Whether a point is inside is told by the side of the nearest point of the true arcs that it lies on; where that is a
/// corner, by whether the corner stands out.
pub fn overlapping(bodies: &Bodies, a: &[f64]) -> Vec<Overlap> {
    overlaps(bodies, a, &|_, _| true)
}

/// The deepest of the sampled points that lie inside another solid, of the pairs of solids that `meets` names.
pub fn deepest(bodies: &Bodies, a: &[f64], meets: &dyn Fn(usize, usize) -> bool) -> Option<Overlap> {
    let all = overlaps(bodies, a, meets).into_iter();
    all.max_by(|a, b| a.depth.total_cmp(&b.depth))
}

fn overlaps(bodies: &Bodies, a: &[f64], meets: &dyn Fn(usize, usize) -> bool) -> Vec<Overlap> {
    let shapes = shapes(bodies, a);
    let deep = |(first, second): (usize, usize)| {
        let (shape, boundary) = (&shapes[second], bodies.solid(second).boundary());
        let all = points(&shapes[first]).map(|p| (p, depth(shape, boundary, &p)));
        let (point, depth) = all.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|p| p.1 > 0.0)?;
        Some(Overlap {
            first,
            second,
            x: point.x,
            y: point.y,
            depth,
        })
    };
    pairs(&shapes).filter(|(i, j)| meets(*i, *j)).filter_map(deep).collect()
}

fn shapes(bodies: &Bodies, a: &[f64]) -> Vec<Shape> {
    (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect()
}

/// Pairs of different solids whose boxes touch, in either order.
fn pairs(shapes: &[Shape]) -> impl Iterator<Item = (usize, usize)> {
    let all = (0..shapes.len()).flat_map(|i| (0..shapes.len()).map(move |j| (i, j)));
    all.filter(|(i, j)| i != j && boxes_near(&shapes[*i].bounds, &shapes[*j].bounds, 0.0))
}

/// The points that stand for a boundary.
fn points(shape: &Shape) -> impl Iterator<Item = Vector2<f64>> {
    let place = |arc: usize, k: u32| {
        let u = f64::from(k) * 2.0 / f64::from(PIECES) - 1.0;
        shape.place(&Cursor { arc, u })
    };
    (0..shape.arcs.len()).flat_map(move |arc| (0..PIECES).map(move |k| place(arc, k)))
}

/// How deep a point lies inside; 0 outside.
fn depth(shape: &Shape, boundary: &Boundary, point: &Vector2<f64>) -> f64 {
    if box_distance(&shape.bounds, point) > 0.0 {
        return 0.0;
    }
    let feet = shape.arcs.iter().map(|nodes| nearest(nodes, *point)).enumerate();
    let Some((arc, foot)) = feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance)) else {
        return 0.0;
    };
    let slope = |arc: usize, u: f64| combine(&shape.arcs[arc], line_slope(u));
    let cross = |a: Vector2<f64>, b: Vector2<f64>| a.x * b.y - a.y * b.x;
    let own = slope(arc, foot.u);
    // The solid lies on the left of its arcs.
    let left = cross(own, foot.offset) > 0.0;
    let inside = if foot.inside {
        left
    } else {
        let turn = if foot.u > 0.0 {
            cross(own, slope(boundary.next[arc], -1.0))
        } else {
            cross(slope(boundary.previous[arc], 1.0), own)
        };
        // Nothing inside is nearest to a corner that stands out, nothing outside to one that goes in.
        let smooth = turn.abs() <= SMOOTH * own.norm_squared();
        if smooth { left } else { turn < 0.0 }
    };
    if inside { foot.distance } else { 0.0 }
}
