//! The least that a slice can cost: bringing its cache lines in.

use std::collections::HashSet;
use std::hint::black_box;

use bus::volume::VolumeView;
use geometry::SlicePlane;
use scene::{Filter, Sampling};
use slice_view_proc::reslice::Samples;

use crate::shared::figures::cpu_ms;

/// Voxels of a cache line of 64 bytes.
const LINE: usize = 32;

/// The cache lines that hold the eight neighbours of every pixel, in the order of the image.
pub(crate) struct Floor {
    /// A voxel of each.
    voxels: Vec<u32>,
}

impl Floor {
    /// The lines for `plane`. Pixels within a voxel of the border are left out: they share the lines of others.
    pub(crate) fn new(volume: &VolumeView<'_>, plane: &SlicePlane) -> Self {
        let samples = Samples::new(volume, plane, &Sampling::from(Filter::Linear));
        let dims = volume.grid.dims();
        // Lines are where the processor sees them, whatever the allocator gave.
        let shift = volume.voxels.as_ptr().addr() / 2 % LINE;
        let mut seen = HashSet::new();
        let mut voxels = Vec::new();
        let [width, height] = plane.size();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let index = samples.at(f64::from(x), f64::from(y), 0.0);
            if !(0..3).all(|a| index[a] >= 0.0 && index[a] < f64::from(dims[a]) - 1.0) {
                continue;
            }
            let low = index.map(|i| i as u32);
            for corner in 0..8 {
                let voxel = volume
                    .layout
                    .offset(std::array::from_fn(|a| low[a] + (corner >> a & 1)));
                if seen.insert((voxel + shift) / LINE) {
                    voxels.push(voxel as u32);
                }
            }
        }
        Self { voxels }
    }

    /// How many they are.
    pub(crate) fn lines(&self) -> usize {
        self.voxels.len()
    }

    /// CPU time to read something in each, ms.
    pub(crate) fn touch_ms(&self, stored: &[i16]) -> f64 {
        cpu_ms(|| {
            let sum = self
                .voxels
                .iter()
                .fold(0_i64, |sum, &voxel| sum + i64::from(stored[voxel as usize]));
            black_box(sum);
        })
    }
}
