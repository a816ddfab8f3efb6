//! Slices of the patient on any grid of voxels.

use geometry::{Ct, Point, VolumeGrid, Voxel};

use crate::canvas::{AIR_HU, Canvas, Solid};
use crate::vec3::{Vec3, sub};

/// Paints slice `k` of `grid` into `out`, row by row, x fastest.
///
/// Every voxel sees the same operations on the same numbers as [`Canvas::hu`] at its centre: what is left out are solids
/// whose box does not hold the voxel, and they would return their input unchanged.
pub(crate) fn fill_slice(canvas: &Canvas, grid: &VolumeGrid, k: u32, out: &mut [i16]) {
    let paint = |solid: &Solid, p: Vec3, value: f64| solid.paint(p, value);
    fill(
        canvas,
        (grid, k),
        AIR_HU,
        paint,
        |voxel, value| *voxel = to_voxel(value),
        out,
    );
}

/// Puts the structures of slice `k` of `grid` into `out`, as [`Canvas::structure`] has them at the voxels' centres.
pub(crate) fn fill_structures(canvas: &Canvas, grid: &VolumeGrid, k: u32, out: &mut [i16]) {
    let paint = |solid: &Solid, p: Vec3, value: u16| solid.structure(p, value);
    fill(canvas, (grid, k), 0, paint, |voxel, value| *voxel = value as i16, out);
}

fn fill<T: Copy>(
    canvas: &Canvas,
    (grid, k): (&VolumeGrid, u32),
    empty: T,
    paint: impl Fn(&Solid, Vec3, T) -> T,
    put: impl Fn(&mut i16, T),
    out: &mut [i16],
) {
    let [nx, ny, _] = grid.dims();
    let mut points = vec![[0.0; 3]; nx as usize];
    let mut values = vec![empty; nx as usize];
    let solids = solids_of_slice(canvas.solids(), grid, k);
    for (j, row) in (0..ny).zip(out.chunks_exact_mut(nx as usize)) {
        for (i, point) in (0..nx).zip(&mut points) {
            *point = centre(grid, i, j, k);
        }
        values.fill(empty);
        paint_row(&solids, &points, &mut values, &paint);
        row.iter_mut()
            .zip(&values)
            .for_each(|(voxel, value)| put(voxel, *value));
    }
}

/// HU to the nearest whole number, halves away from zero, held to what an i16 holds.
pub(crate) fn to_voxel(hu: f64) -> i16 {
    // `as` saturates, and rounding comes first: no HU changes sign or wraps.
    hu.round() as i16
}

fn centre(grid: &VolumeGrid, i: u32, j: u32, k: u32) -> Vec3 {
    let voxel = Point::<Voxel>::new(f64::from(i), f64::from(j), f64::from(k));
    let p: Point<Ct> = grid.ct_from_voxel() * voxel;
    p.mm()
}

/// The solids whose boxes meet the slice's, in order.
fn solids_of_slice<'a>(solids: &'a [Solid], grid: &VolumeGrid, k: u32) -> Vec<&'a Solid> {
    let [nx, ny, _] = grid.dims();
    let corners = [(0, 0), (nx - 1, 0), (0, ny - 1), (nx - 1, ny - 1)].map(|(i, j)| centre(grid, i, j, k));
    let low = std::array::from_fn(|i| corners.iter().map(|c| c[i]).fold(f64::INFINITY, f64::min));
    let high = std::array::from_fn(|i| corners.iter().map(|c| c[i]).fold(f64::NEG_INFINITY, f64::max));
    solids.iter().filter(|s| s.meets(low, high)).collect()
}

fn paint_row<T: Copy>(solids: &[&Solid], points: &[Vec3], values: &mut [T], paint: &impl Fn(&Solid, Vec3, T) -> T) {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return;
    };
    let low = std::array::from_fn(|i| first[i].min(last[i]));
    let high = std::array::from_fn(|i| first[i].max(last[i]));
    let steps = (points.len() - 1).max(1) as f64;
    let step = sub(*last, *first).map(|d| d / steps);
    for solid in solids.iter().filter(|s| s.meets(low, high)) {
        let span = solid.span(*first, step, points.len());
        for (point, value) in points[span.clone()].iter().zip(&mut values[span]) {
            *value = paint(solid, *point, *value);
        }
    }
}
