//! What is told of a body above the threshold.

use crate::voxels::VoxelBox;

/// A body above the threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component {
    /// Voxels of it.
    pub voxels: u64,
    /// Its volume, ml.
    pub volume_ml: f64,
    /// Mean of its voxels, mm (left, posterior, superior).
    pub centre_mm: [f64; 3],
    /// Mean of its voxels, HU.
    pub mean_hu: f64,
    /// Where it lies in the CT.
    pub place: VoxelBox,
}
