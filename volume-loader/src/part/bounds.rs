//! From a region in millimetres or voxels to the voxels that it holds.

use std::ops::RangeInclusive;

use geometry::{Ct, GridError, Point, VolumeGrid};
use scene::Region;

/// Why a part of an examination was not cut out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegionError {
    /// Nothing of the examination lies in the region.
    #[error(
        "the region from {low:?} to {high:?} mm (LPS) and the examination from {ct_low:?} to {ct_high:?} mm have nothing in \
         common; check the region's axes and signs"
    )]
    Outside {
        /// The region's corner of smallest coordinates.
        low: [f64; 3],
        /// Of largest.
        high: [f64; 3],
        /// The examination's, likewise.
        ct_low: [f64; 3],
        /// Of largest.
        ct_high: [f64; 3],
    },
    /// The voxels asked for are not all there.
    #[error(
        "the region ends before voxel {found:?}, and the examination before {dims:?}: ask for voxels that are there"
    )]
    Voxels {
        /// One behind the last voxel asked for.
        found: [u32; 3],
        /// Voxels of the examination.
        dims: [u32; 3],
    },
    /// There is no target, and so no margin around one.
    #[error("the region is a margin around the targets, and the scene has none")]
    NoTargets,
    /// The part is thinner than one block.
    #[error("along axis {axis} the part has {voxels} voxels, fewer than the {block} that are to become one")]
    Block {
        /// Which axis, 0 to 2.
        axis: usize,
        /// Voxels of the part.
        voxels: u32,
        /// Voxels to join.
        block: u32,
    },
    /// The joined voxels are larger than any scanner's.
    #[error("the part that was asked for: {0}")]
    Grid(#[from] GridError),
}

/// First voxel and one behind the last of the smallest box of voxels that holds `region`, as far as there are voxels.
pub(super) fn of(region: &Region, grid: &VolumeGrid) -> Result<[[u32; 3]; 2], RegionError> {
    match region {
        Region::BoxVoxels([first, end]) => {
            let (dims, found) = (grid.dims(), *end);
            if (0..3).any(|a| end[a] > dims[a] || first[a] >= end[a]) {
                return Err(RegionError::Voxels { found, dims });
            }
            Ok([*first, *end])
        }
        Region::BoxMm(corners) => of_box(corners, 0.0, grid),
        Region::Around { points, .. } if points.is_empty() => Err(RegionError::NoTargets),
        Region::Around { points, margin_mm } => of_box(points, *margin_mm, grid),
    }
}

fn of_box(points: &[Point<Ct>], margin_mm: f64, grid: &VolumeGrid) -> Result<[[u32; 3]; 2], RegionError> {
    let along = |a: usize| points.iter().map(move |p| p.mm()[a]);
    let low: [f64; 3] = std::array::from_fn(|a| along(a).fold(f64::INFINITY, f64::min) - margin_mm);
    let high: [f64; 3] = std::array::from_fn(|a| along(a).fold(f64::NEG_INFINITY, f64::max) + margin_mm);
    let voxels = in_voxels(low, high, grid);
    let (mut first, mut end) = ([0; 3], [0; 3]);
    for (a, range) in voxels.into_iter().enumerate() {
        let last = f64::from(grid.dims()[a]) - 1.0;
        if *range.end() < -0.5 || *range.start() > last + 0.5 {
            let (ct_low, ct_high) = grid.bounds();
            let [ct_low, ct_high] = [ct_low.mm(), ct_high.mm()];
            return Err(RegionError::Outside {
                low,
                high,
                ct_low,
                ct_high,
            });
        }
        // Within 0 and the last voxel: whole numbers that fit. One voxel more on each side, for interpolation.
        first[a] = range.start().floor().clamp(0.0, last) as u32;
        end[a] = range.end().ceil().clamp(0.0, last) as u32 + 1;
    }
    Ok([first, end])
}

/// The box in voxel coordinates that holds a box in the patient's.
fn in_voxels(low: [f64; 3], high: [f64; 3], grid: &VolumeGrid) -> [RangeInclusive<f64>; 3] {
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for corner in 0..8 {
        let [x, y, z] = std::array::from_fn(|a| if corner >> a & 1 == 1 { high[a] } else { low[a] });
        let voxel = (grid.voxel_from_ct() * Point::<Ct>::new(x, y, z)).mm();
        for (bound, v) in bounds.iter_mut().zip(voxel) {
            *bound = [bound[0].min(v), bound[1].max(v)];
        }
    }
    bounds.map(|[low, high]| low..=high)
}
