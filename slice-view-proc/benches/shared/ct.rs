//! A volume of the usual size: 512 x 512 x 400 voxels of 0.7 x 0.7 x 0.8 mm, 200 MiB.

use bus::message::VolumeHash;
use bus::volume::{Layout, OwnedVolume, Voxels};
use geometry::{Affine, Point, Vector, VolumeGrid};

pub(crate) const DIMS: [u32; 3] = [512, 512, 400];
pub(crate) const SPACING_MM: [f64; 3] = [0.7, 0.7, 0.8];
/// The middle of the volume, mm: the generated patient's.
pub(crate) const CENTRE_MM: [f64; 3] = [0.0, 0.0, 40.0];

/// A grid along the patient's axes about [`CENTRE_MM`].
pub(crate) fn grid(dims: [u32; 3], spacing_mm: [f64; 3]) -> VolumeGrid {
    let [sx, sy, sz] = spacing_mm;
    let first = |a: usize| CENTRE_MM[a] - spacing_mm[a] * (f64::from(dims[a]) - 1.0) / 2.0;
    let steps = [
        Vector::new(sx, 0.0, 0.0),
        Vector::new(0.0, sy, 0.0),
        Vector::new(0.0, 0.0, sz),
    ];
    let ct_from_voxel = Affine::from_steps(Point::new(first(0), first(1), first(2)), steps);
    VolumeGrid::checked(dims.map(i64::from), ct_from_voxel).expect("a usual grid")
}

/// A volume laid out as a loader lays it out; `slice` fills slice z row by row.
pub(crate) fn volume(grid: VolumeGrid, mut slice: impl FnMut(u32, &mut [i16])) -> OwnedVolume {
    let dims = grid.dims();
    let layout = Layout::choose(dims).expect("a usual size");
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    let mut row_by_row = vec![0; (dims[0] * dims[1]) as usize];
    for z in 0..dims[2] {
        slice(z, &mut row_by_row);
        layout.scatter(z, &row_by_row, &mut voxels);
    }
    OwnedVolume {
        grid,
        layout,
        voxels,
        padding_hu: -1024,
        // Nobody asks for its name.
        hash: VolumeHash([0; 32]),
        marks: bus::message::Marks::NONE,
    }
}

/// The CT: waves of 20 to 90 voxels with a texture of up to 100 HU, so that no value is special.
#[allow(dead_code, reason = "the trade-off's volumes have a closed form")]
pub(crate) fn textured() -> OwnedVolume {
    let wave = |i: u32, length: f64| 500.0 * (f64::from(i) * std::f64::consts::TAU / length).cos();
    let [x_waves, y_waves]: [Vec<f64>; 2] =
        [(0, 37.0), (1, 53.0)].map(|(a, length)| (0..DIMS[a]).map(|i| wave(i, length)).collect());
    let mut noise = 0x9e37_79b9_u32;
    volume(grid(DIMS, SPACING_MM), |z, slice| {
        let z_wave = wave(z, 29.0);
        for (row, y_wave) in slice.chunks_exact_mut(DIMS[0] as usize).zip(&y_waves) {
            for (value, x_wave) in row.iter_mut().zip(&x_waves) {
                noise ^= noise << 13;
                noise ^= noise >> 17;
                noise ^= noise << 5;
                *value = (x_wave + y_wave + z_wave) as i16 + (noise % 201) as i16 - 100;
            }
        }
    })
}
