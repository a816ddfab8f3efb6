//! How the markers of a tool lie to one another.

use super::RomError;

/// Markers closer to one line than this are on it, mm. Spheres have 11.5 mm across, and a localizer sees them within
/// 0.3.
const LINE_MM: f64 = 2.0;
/// Markers closer to one another than this are one, mm.
const TOGETHER_MM: f64 = 1.0;

/// What poses a tool can have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Its markers span a plane or more: all six degrees of freedom.
    Body,
    /// They lie on a line: the turn about it is not seen.
    Line {
        /// The largest distance of one from it, mm.
        off_mm: f64,
    },
}

pub(super) fn shape(markers: &[[f64; 3]]) -> Result<Shape, RomError> {
    let mut longest = ([0.0; 3], [1.0, 0.0, 0.0], 0.0);
    for (second, b) in markers.iter().enumerate() {
        for (first, a) in markers.iter().take(second).enumerate() {
            let along = less(*b, *a);
            let length = norm(along);
            if length < TOGETHER_MM {
                let found_mm = length;
                return Err(RomError::Together {
                    first,
                    second,
                    found_mm,
                });
            }
            if length > longest.2 {
                longest = (*a, along.map(|x| x / length), length);
            }
        }
    }
    // The line through the two that are farthest apart is within a factor of two of the best one.
    let (from, along, _) = longest;
    let off = |marker: &[f64; 3]| norm(cross(less(*marker, from), along));
    let off_mm = markers.iter().map(off).fold(0.0, f64::max);
    Ok(if off_mm < LINE_MM {
        Shape::Line { off_mm }
    } else {
        Shape::Body
    })
}

fn less([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
