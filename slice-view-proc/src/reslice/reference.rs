//! The f64 reference: plain code, one pixel at a time, the oracle of every other back end.

use bus::scene::Filter;
use bus::volume::VolumeView;
use geometry::SlicePlane;

use super::{IndexPlane, Resampler};

/// The reference back end.
#[derive(Debug, Default, Clone, Copy)]
pub struct Reference;

impl Resampler for Reference {
    fn name(&self) -> &'static str {
        "cpu-reference-f64"
    }

    fn error_bound_hu(&self, _: Filter, max_abs_hu: f64) -> f64 {
        // The result is stored as f32.
        max_abs_hu * f64::from(f32::EPSILON) / 2.0
    }

    fn reslice(&mut self, volume: &VolumeView<'_>, plane: &SlicePlane, filter: Filter, hu: &mut [f32]) {
        let index = IndexPlane::new(volume, plane);
        let width = plane.size()[0] as usize;
        for (row, line) in hu.chunks_exact_mut(width).enumerate() {
            for (column, value) in line.iter_mut().enumerate() {
                *value = sample(volume, index.at(column as f64, row as f64), filter) as f32;
            }
        }
    }
}

/// The HU at a continuous voxel index.
pub(super) fn sample(volume: &VolumeView<'_>, index: [f64; 3], filter: Filter) -> f64 {
    let dims = volume.grid.dims().map(f64::from);
    if !(0..3).all(|a| index[a] >= -0.5 && index[a] <= dims[a] - 0.5) {
        return f64::from(volume.padding_hu);
    }
    let inside: [f64; 3] = std::array::from_fn(|a| index[a].clamp(0.0, dims[a] - 1.0));
    match filter {
        Filter::Nearest => f64::from(volume.at(inside.map(|v| (v + 0.5).floor() as u32))),
        Filter::Linear => trilinear(volume, inside),
    }
}

/// Trilinear interpolation at an index between the outermost voxel centres.
fn trilinear(volume: &VolumeView<'_>, index: [f64; 3]) -> f64 {
    let dims = volume.grid.dims();
    // The last cell is closed on both sides; an axis of one voxel has no cell and no weight.
    let low: [u32; 3] = std::array::from_fn(|a| (index[a] as u32).min(dims[a].saturating_sub(2)));
    let weight: [f64; 3] = std::array::from_fn(|a| index[a] - f64::from(low[a]));
    let mut sum = 0.0;
    for corner in 0..8_u32 {
        let mut w = 1.0;
        let voxel: [u32; 3] = std::array::from_fn(|a| {
            let far = corner >> a & 1;
            w *= if far == 1 { weight[a] } else { 1.0 - weight[a] };
            (low[a] + far).min(dims[a] - 1)
        });
        if w > 0.0 {
            sum += w * f64::from(volume.at(voxel));
        }
    }
    sum
}
