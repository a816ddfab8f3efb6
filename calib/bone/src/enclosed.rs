//! Walls of cavities that are open somewhere: no outer surface, though what is outside reaches them.
//!
//! Through a hole wider than the filling closes, what lies outside a bone reaches its marrow, and the inner wall is as much of the surface as
//! the outer one. What tells them apart is what is seen from there: before the outer wall of a bone lies the open, before the inner one bone
//! nearly all around.

use nalgebra::Vector3;

use crate::voxels::Crop;

/// Directions that are looked in from a place.
const DIRECTIONS: usize = 32;
/// With so many of them open a place is outside. A hole of 12 mm in a ball of 28 mm is a twentieth of what is seen from its inner wall, on
/// average; from within a socket of the half ball at least half is open.
const OPEN: usize = 4;
/// The least cosine to the normal: nearer to the surface its own roughness is seen.
const LEAST_COSINE: f64 = 0.25;
/// Where a look begins, in the voxels' largest step.
const START_STEPS: f64 = 2.0;

/// Whether bone is nearly all around before a place of the surface of what is 1 in `mask`.
pub(crate) fn is_enclosed(crop: &Crop, mask: &[u8], place: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
    let lengths = [0, 1, 2].map(|k| crop.steps.column(k).norm());
    let [least, most] = [f64::min, f64::max].map(|of| lengths.iter().copied().reduce(of).unwrap_or(1.0));
    let side = if normal.x.abs() < 0.6 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let Some(u) = normal.cross(&side).try_normalize(0.0) else {
        return false;
    };
    let v = normal.cross(&u);
    let mut open = 0;
    for i in 0..DIRECTIONS {
        // Evenly over the cap, by the golden angle; strewn in height, so that the first few are spread as well.
        let height = ((i * 13 % DIRECTIONS) as f64 + 0.5) / DIRECTIONS as f64;
        let cosine = LEAST_COSINE + (1.0 - LEAST_COSINE) * height;
        let (sine, turn) = ((1.0 - cosine * cosine).sqrt(), 2.399_963_229_728_653 * i as f64);
        let direction = normal * cosine + (u * turn.cos() + v * turn.sin()) * sine;
        open += usize::from(is_open(
            crop,
            mask,
            place + normal * (START_STEPS * most),
            direction * least,
        ));
        if open >= OPEN {
            return false;
        }
    }
    true
}

/// Whether a look meets no bone before the part of the CT ends.
fn is_open(crop: &Crop, mask: &[u8], from: Vector3<f64>, step: Vector3<f64>) -> bool {
    let (mut at, step) = (crop.index(&from), crop.index_from_mm * step);
    loop {
        let voxel = at.map(f64::round);
        if (0..3).any(|k| !(voxel[k] >= 0.0 && voxel[k] < crop.dims[k] as f64)) {
            return true;
        }
        if mask[crop.offset([0, 1, 2].map(|k| voxel[k] as usize))] == 1 {
            return false;
        }
        at += step;
    }
}
