//! The pelvis of a generated patient, from his CT.

use bone::{Bone, Options, Region, Voxels, extract};
use geometry::VolumeGrid;
use phantom::Phantom;

/// Voxels of a CT of the abdomen, mm.
const SPACING_MM: [f64; 3] = [1.5; 3];
/// Vessels with contrast are below, bone of the generated patient above, HU.
const LEVEL_HU: f64 = 300.0;
/// Where the pelvis is, without the lumbar spine and its own cut end, mm.
const BOX_MM: [[f64; 3]; 2] = [[-150.0, -90.0, -133.0], [150.0, 100.0, -12.0]];

struct Ct {
    grid: VolumeGrid,
    voxels: Vec<i16>,
}

impl Voxels for Ct {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        let [columns, rows, _] = self.grid.dims().map(|n| n as usize);
        let first = (z as usize * rows + y as usize) * columns;
        out.copy_from_slice(&self.voxels[first..first + columns]);
    }
}

pub(crate) fn pelvis(patient: &Phantom) -> Bone {
    let grid = patient.grid(SPACING_MM).unwrap();
    let [columns, rows, slices] = grid.dims();
    let mut voxels = vec![0; (columns * rows * slices) as usize];
    for (slice, z) in voxels.chunks_exact_mut((columns * rows) as usize).zip(0..) {
        patient.fill_slice(&grid, z, slice);
    }
    let options = Options {
        level_hu: LEVEL_HU,
        threads: 2,
        ..Options::of(Region::Box { corners_mm: BOX_MM })
    };
    extract(&Ct { grid, voxels }, &options).unwrap()
}
