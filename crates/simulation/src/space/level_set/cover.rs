//! Points of a surface, close together everywhere that is wanted of a box.

use nalgebra::Vector3;

use super::NoSurface;
use super::foot::{descend, unit};
use crate::space::cells::{Curved, is_clear, steepest};

/// More parts of a surface than these are refused, and more boxes looked at.
const MOST_PARTS: usize = 1_000_000;
const MOST_BOXES: usize = 16 * MOST_PARTS;

/// A part of a surface: a point of it, and corners of the box that it lies in.
pub(super) struct Part {
    pub(super) foot: Vector3<f64>,
    pub(super) corners: [Vector3<f64>; 2],
}

/// Parts of the surface in a box, but for those in boxes that `is_wanted` says no of; and what no other point of it is farther from all feet than.
pub(super) fn parts(
    field: &dyn Curved,
    corners: [Vector3<f64>; 2],
    spacing: f64,
    is_wanted: &dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
) -> Result<(Vec<Part>, f64), NoSurface> {
    let too_many = NoSurface::TooMany {
        side: spacing,
        most: MOST_PARTS,
    };
    let (mut waiting, mut looked) = (vec![(corners, None)], 0);
    let (mut parts, mut cover) = (Vec::new(), 0.0_f64);
    while let Some(([low, high], known)) = waiting.pop() {
        if !is_wanted(&low, &high) {
            continue;
        }
        looked += 1;
        // Smaller boxes have no tighter bounds: those of the one that they are in serve.
        let is_fine = (high - low).max() <= 2.0 * field.resolution();
        let steepest: Option<Vector3<f64>> = match known {
            Some(_) => known,
            None if is_beside(field, &low, &high) => continue,
            None => is_fine.then(|| steepest(field, &low, &high)),
        };
        if steepest.is_some_and(|steepest| is_clear(field, &low, &high, &steepest)) {
            continue;
        }
        let side = high - low;
        if side.norm() <= spacing {
            let (centre, half) = ((low + high) * 0.5, 0.5 * side.norm());
            // No foot within the diagonal: the bounds were not tight, and no surface is in this box.
            if let Some(foot) = descend(field, centre).filter(|foot| (foot - centre).norm() <= 2.0 * half) {
                cover = cover.max((foot - centre).norm() + half);
                parts.push(Part {
                    foot,
                    corners: [low, high],
                });
            }
        } else {
            let axis = side.imax();
            let middle = low[axis] + 0.5 * side[axis];
            let (mut lower, mut upper) = (high, low);
            (lower[axis], upper[axis]) = (middle, middle);
            waiting.extend([([low, lower], steepest), ([upper, high], steepest)]);
        }
        if parts.len() > MOST_PARTS || looked > MOST_BOXES {
            return Err(too_many);
        }
    }
    if parts.is_empty() {
        return Err(NoSurface::Empty);
    }
    Ok((parts, cover))
}

/// Whether no surface is in a box by the field's own bounds.
fn is_beside(field: &dyn Curved, low: &Vector3<f64>, high: &Vector3<f64>) -> bool {
    let bounds = field.bounds(low, high);
    bounds[0] > 0.0 || bounds[1] < 0.0
}

impl Part {
    /// The area of the plane through its foot that lies in its box, mm^2: boxes side by side share no part of a surface.
    pub(super) fn area(&self, normal: &Vector3<f64>) -> f64 {
        let [low, high] = self.corners;
        let across = unit(&normal.cross(&Vector3::ith(normal.iamin(), 1.0)));
        let other = normal.cross(&across);
        // A square that the box is in, wherever in it the foot is; the planes of the box's faces cut it to what is inside.
        let half = 2.0 * (high - low).norm() + (self.foot - 0.5 * (low + high)).norm();
        let corner = |a: f64, b: f64| self.foot + (across * a + other * b) * half;
        let mut polygon = vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        for axis in 0..3 {
            polygon = cut(&polygon, |at| at[axis] - low[axis]);
            polygon = cut(&polygon, |at| high[axis] - at[axis]);
        }
        let triangles = polygon
            .windows(2)
            .map(|side| (side[0] - self.foot).cross(&(side[1] - self.foot)));
        let last = polygon.last().zip(polygon.first());
        let last = last.map(|(one, next)| (one - self.foot).cross(&(next - self.foot)));
        0.5 * triangles.chain(last).sum::<Vector3<f64>>().norm()
    }
}

/// The part of a convex polygon where a linear function of the place is not below zero.
fn cut(polygon: &[Vector3<f64>], inside: impl Fn(&Vector3<f64>) -> f64) -> Vec<Vector3<f64>> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, at) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let (here, there) = (inside(at), inside(next));
        if here >= 0.0 {
            kept.push(*at);
        }
        if (here >= 0.0) != (there >= 0.0) {
            kept.push(at + (next - at) * (here / (here - there)));
        }
    }
    kept
}
