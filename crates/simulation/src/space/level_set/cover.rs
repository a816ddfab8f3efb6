//! Points of a surface, close together everywhere in a box.

use nalgebra::Vector3;

use super::NoSurface;
use super::foot::descend;
use crate::space::cells::Curved;

/// More parts of a surface than these are refused, and more boxes looked at.
const MOST_PARTS: usize = 1_000_000;
const MOST_BOXES: usize = 16 * MOST_PARTS;

/// Points of the surface in a box, and what no other of it is farther from all of them than.
pub(super) fn feet(
    field: &dyn Curved,
    corners: [Vector3<f64>; 2],
    spacing: f64,
) -> Result<(Vec<Vector3<f64>>, f64), NoSurface> {
    let too_many = NoSurface::TooMany {
        side: spacing,
        most: MOST_PARTS,
    };
    let (mut waiting, mut looked) = (vec![corners], 0);
    let (mut feet, mut cover) = (Vec::new(), 0.0_f64);
    while let Some([low, high]) = waiting.pop() {
        looked += 1;
        let bounds = field.bounds(&low, &high);
        if bounds[0] > 0.0 || bounds[1] < 0.0 {
            continue;
        }
        let side = high - low;
        if side.norm() <= spacing {
            let (centre, half) = ((low + high) * 0.5, 0.5 * side.norm());
            // No foot within the diagonal: the bounds were not tight, and no surface is in this box.
            if let Some(foot) = descend(field, centre).filter(|foot| (foot - centre).norm() <= 2.0 * half) {
                cover = cover.max((foot - centre).norm() + half);
                feet.push(foot);
            }
        } else {
            let axis = side.imax();
            let middle = low[axis] + 0.5 * side[axis];
            let (mut lower, mut upper) = (high, low);
            (lower[axis], upper[axis]) = (middle, middle);
            waiting.extend([[low, lower], [upper, high]]);
        }
        if feet.len() > MOST_PARTS || looked > MOST_BOXES {
            return Err(too_many);
        }
    }
    if feet.is_empty() {
        return Err(NoSurface::Empty);
    }
    Ok((feet, cover))
}
