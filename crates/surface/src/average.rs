//! Fewer samples than voxels: means of blocks. Stepping over voxels would put holes into thin bone.

use geometry::{Affine, Ct, Point, VolumeGrid, Voxel};

/// More samples than this are averaged: an image of their surface would take longer than a camera that turns may.
pub const MOST_SAMPLES: u64 = 12_000_000;

/// Sides of a block of voxels that become one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Average(pub [u32; 3]);

impl Average {
    /// Blocks that leave at most `most` samples of `grid`, as close to cubes as its voxels allow.
    pub fn of(grid: &VolumeGrid, most: u64) -> Self {
        let mut sides = [1_u32; 3];
        let spacing = grid.spacing_mm();
        // A side of 64 voxels leaves few of any grid.
        while Self(sides).samples(grid) > most && sides.iter().any(|side| *side < 64) {
            let step = |axis: usize| spacing[axis] * f64::from(sides[axis]);
            let least = (0..3).map(step).fold(f64::INFINITY, f64::min);
            // Axes that are nearly as fine as the finest grow with it.
            let grown = [0, 1, 2].map(|axis| step(axis) < 1.5 * least);
            (0..3).filter(|axis| grown[*axis]).for_each(|axis| sides[axis] *= 2);
        }
        Self(sides)
    }

    fn samples(self, grid: &VolumeGrid) -> u64 {
        self.dims(grid).iter().map(|n| u64::from(*n)).product()
    }

    /// Samples along each axis; the last block of an axis may be short, and has its last voxel repeated.
    pub fn dims(self, grid: &VolumeGrid) -> [u32; 3] {
        [0, 1, 2].map(|axis| grid.dims()[axis].div_ceil(self.0[axis]))
    }

    /// From the number of a sample to the patient: its place is the middle of its block.
    pub fn ct_from_sample(self, grid: &VolumeGrid) -> Affine<Ct, Voxel> {
        let [fx, fy, fz] = self.0.map(f64::from);
        let first = Point::new((fx - 1.0) / 2.0, (fy - 1.0) / 2.0, (fz - 1.0) / 2.0);
        let steps = [(0, fx), (1, fy), (2, fz)].map(|(axis, factor)| grid.ct_from_voxel().step(axis) * factor);
        Affine::from_steps(grid.ct_from_voxel() * first, steps)
    }

    /// For each block of layer `z`, row by row: its number in the layer, and each of its voxels. `read` writes a layer of voxels.
    pub(crate) fn each(
        self,
        grid: &VolumeGrid,
        z: u32,
        slice: &mut [i16],
        mut read: impl FnMut(u32, &mut [i16]),
        mut take: impl FnMut(usize, i16),
    ) {
        let [nx, ny, nz] = grid.dims();
        let [fx, fy, fz] = self.0;
        let [columns, rows, _] = self.dims(grid);
        for dz in 0..fz {
            read((z * fz + dz).min(nz - 1), slice);
            for y in 0..rows * fy {
                let row = &slice[(y.min(ny - 1) * nx) as usize..][..nx as usize];
                let first = (y / fy * columns) as usize;
                for x in 0..columns * fx {
                    take(first + (x / fx) as usize, row[x.min(nx - 1) as usize]);
                }
            }
        }
    }
}
