//! Sampling a plane out of the volume.
//!
//! **Border rule**, the same for every back end and filter: the volume is the union of its voxels' cells, so a continuous
//! index v is inside when -1/2 <= v <= n - 1/2 on every axis. Inside, indices beyond the outermost voxel centres are
//! moved onto them (the outer half cells hold their voxel's value); outside, the result is the padding value.

mod cpu;
mod reference;

use bus::scene::Filter;
use bus::volume::VolumeView;
use geometry::SlicePlane;

pub use cpu::Cpu;
pub use reference::Reference;

/// A way of sampling a plane. Back ends differ in speed and in the error they state, never in the border rule.
pub trait Resampler {
    /// The name in reports.
    fn name(&self) -> &'static str;

    /// The largest distance of a result from the f64 reference, HU, for voxels up to `max_abs_hu` in magnitude.
    ///
    /// For [`Filter::Nearest`] it holds away from ties: where an index lies in the middle between two voxels to within
    /// the back end's rounding (4e-9 of a voxel for [`Cpu`]), either of the two may be given.
    fn error_bound_hu(&self, filter: Filter, max_abs_hu: f64) -> f64;

    /// Samples `plane` into `hu`, row by row; `hu` holds width x height values.
    fn reslice(&mut self, volume: &VolumeView<'_>, plane: &SlicePlane, filter: Filter, hu: &mut [f32]);
}

/// The index part of a plane: voxel index of the first pixel, and the steps of one column and one row.
#[derive(Debug, Clone, Copy)]
struct IndexPlane {
    origin: [f64; 3],
    right: [f64; 3],
    down: [f64; 3],
}

impl IndexPlane {
    fn new(volume: &VolumeView<'_>, plane: &SlicePlane) -> Self {
        let voxel_from_ct = volume.grid.voxel_from_ct();
        Self {
            origin: (voxel_from_ct * plane.origin()).mm(),
            right: (voxel_from_ct * plane.step_right()).mm(),
            down: (voxel_from_ct * plane.step_down()).mm(),
        }
    }

    /// The continuous voxel index of pixel (`x`, `y`).
    fn at(&self, x: f64, y: f64) -> [f64; 3] {
        std::array::from_fn(|a| self.origin[a] + self.right[a] * x + self.down[a] * y)
    }
}
