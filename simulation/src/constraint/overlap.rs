//! Solids that overlap at the start.

use nalgebra::Vector2;

use super::nearest::nearest;
use super::shape::{Shape, box_distance, boxes_near};
use crate::q9::shape::line_slope;
use crate::solid::Cursor;
use crate::system::Bodies;

/// Two solids that overlap.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("solids {first} and {second} overlap at ({x:.6}, {y:.6}): move one of them away before the start")]
pub struct Overlap {
    /// A solid.
    pub first: usize,
    /// Another.
    pub second: usize,
    /// Where a point of the first lies in the second.
    pub x: f64,
    /// Where a point of the first lies in the second.
    pub y: f64,
}

/// Points of each arc that stand for it.
const PIECES: u32 = 8;

/// Pairs of solids of which one has a sampled point of its boundary inside the other.
///
/// Whether a point is inside is told by the side of the nearest point of the true arcs that it lies on; near corners, by
/// the chords' winding.
pub fn overlapping(bodies: &Bodies, a: &[f64]) -> Vec<Overlap> {
    let shapes: Vec<Shape> = (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect();
    let polygons: Vec<Vec<[Vector2<f64>; 2]>> = shapes.iter().map(chords).collect();
    let mut found = Vec::new();
    for first in 0..bodies.len() {
        for second in (0..bodies.len()).filter(|s| *s != first) {
            if !boxes_near(&shapes[first].bounds, &shapes[second].bounds, 0.0) {
                continue;
            }
            let within = |p: &Vector2<f64>| inside(&shapes[second], &polygons[second], p);
            let point = polygons[first].iter().map(|chord| chord[0]).find(within);
            if let Some(point) = point {
                found.push(Overlap {
                    first,
                    second,
                    x: point.x,
                    y: point.y,
                });
            }
        }
    }
    found
}

fn inside(shape: &Shape, polygon: &[[Vector2<f64>; 2]], point: &Vector2<f64>) -> bool {
    if box_distance(&shape.bounds, point) > 0.0 {
        return false;
    }
    let feet = shape.arcs.iter().map(|arc| (arc, nearest(arc, *point)));
    let Some((arc, foot)) = feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance)) else {
        return false;
    };
    if !foot.inside {
        return winds(polygon, point);
    }
    let slope: Vector2<f64> = arc.iter().zip(line_slope(foot.u)).map(|(p, s)| p * s).sum();
    // The solid lies on the left of its arcs.
    slope.x * foot.offset.y - slope.y * foot.offset.x > 0.0
}

fn chords(shape: &Shape) -> Vec<[Vector2<f64>; 2]> {
    let place = |arc: usize, k: u32| {
        let u = f64::from(k) * 2.0 / f64::from(PIECES) - 1.0;
        shape.place(&Cursor { arc, u })
    };
    let arcs = 0..shape.arcs.len();
    arcs.flat_map(|arc| (0..PIECES).map(move |k| [place(arc, k), place(arc, k + 1)]))
        .collect()
}

/// True where the chords wind round a point: crossings of the ray to the right.
fn winds(chords: &[[Vector2<f64>; 2]], point: &Vector2<f64>) -> bool {
    let crosses = |[p, q]: &&[Vector2<f64>; 2]| {
        let spans = (p.y > point.y) != (q.y > point.y);
        spans && point.x < p.x + (q.x - p.x) * (point.y - p.y) / (q.y - p.y)
    };
    chords.iter().filter(crosses).count() % 2 == 1
}
