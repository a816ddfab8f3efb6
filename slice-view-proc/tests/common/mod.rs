//! Volumes made by a formula, planes, and images of them.

#![allow(unreachable_pub, reason = "a module of each test file, and not a crate")]
#![allow(dead_code, reason = "each test file uses its own part of it")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use bus::message::VolumeHash;
use bus::volume::{Layout, OwnedVolume, Voxels};
use geometry::{Affine, Ct, Direction, Point, SlicePlane, VolumeGrid};
use scene::{Filter, Minify, Sampling, Slab, SlabMode};
use slice_view_proc::reslice::{Cpu, Reference, Resampler};

pub const PADDING_HU: i16 = -1024;

/// A volume of 1 mm voxels about voxel (0, 0, 0) at the origin, in the layout a loader would choose.
pub fn volume(dims: [u32; 3], hu: impl Fn([i64; 3]) -> i16) -> OwnedVolume {
    let unit = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    volume_at(dims, unit, hu)
}

/// The same with any `ct_from_voxel`.
pub fn volume_at(dims: [u32; 3], ct_from_voxel: [[f64; 4]; 3], hu: impl Fn([i64; 3]) -> i16) -> OwnedVolume {
    let layout = Layout::choose(dims).unwrap();
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    let [nx, ny, nz] = dims.map(i64::from);
    for z in 0..nz {
        let slice: Vec<i16> = (0..nx * ny).map(|i| hu([i % nx, i / nx, z])).collect();
        layout.scatter(z as u32, &slice, &mut voxels);
    }
    OwnedVolume {
        grid: VolumeGrid::checked(dims.map(i64::from), Affine::from_rows(ct_from_voxel)).unwrap(),
        layout,
        voxels,
        padding_hu: PADDING_HU,
        hash: VolumeHash::default(),
        marks: bus::message::Marks::NONE,
    }
}

/// Noise from -2000 to 2000 HU, a pure function of the voxel.
pub fn noise([x, y, z]: [i64; 3]) -> i16 {
    let mut state = (x * 73_856_093) ^ (y * 19_349_663) ^ (z * 83_492_791);
    for _ in 0..3 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        state ^= state >> 29;
    }
    (state.rem_euclid(4001) - 2000) as i16
}

pub fn plane(centre: [f64; 3], axes: [Direction<Ct>; 2], pixel_mm: f64, size: [u32; 2]) -> SlicePlane {
    SlicePlane::centred(Point::new(centre[0], centre[1], centre[2]), axes, pixel_mm, size).unwrap()
}

/// The image of `plane`.
pub fn image(back_end: &mut dyn Resampler, volume: &OwnedVolume, plane: &SlicePlane, sampling: Sampling) -> Vec<f32> {
    let [width, height] = plane.size();
    let mut hu = vec![f32::NAN; width as usize * height as usize];
    back_end.prepare(&volume.view(), &[sampling], &mut || {}).unwrap();
    back_end.reslice(&volume.view(), plane, &sampling, &mut hu).unwrap();
    hu
}

pub fn fast(volume: &OwnedVolume, plane: &SlicePlane, sampling: Sampling) -> Vec<f32> {
    image(&mut Cpu::default(), volume, plane, sampling)
}

pub fn exact(volume: &OwnedVolume, plane: &SlicePlane, sampling: Sampling) -> Vec<f32> {
    image(&mut Reference::default(), volume, plane, sampling)
}

/// What the fast back end and the reference may differ by, for voxels of up to `max_abs_hu`.
pub fn bound(sampling: Sampling, max_abs_hu: f64) -> f32 {
    let of = |back_end: &dyn Resampler| back_end.error_bound_hu(&sampling, max_abs_hu);
    (of(&Cpu::default()) + of(&Reference::default())) as f32
}

/// Every filter, thin, through a slab, and over areas.
pub fn samplings() -> Vec<Sampling> {
    let thick = |mode| {
        Some(Slab {
            mode,
            thickness_mm: 3.0,
        })
    };
    let of = |filter: Filter| {
        let thin = Sampling::from(filter);
        let area = Sampling {
            minify: Minify::Area,
            ..thin
        };
        let slabs = [SlabMode::Mean, SlabMode::Maximum, SlabMode::Minimum];
        let slabs = slabs.map(|mode| Sampling {
            slab: thick(mode),
            ..area
        });
        [&[thin, area][..], &slabs].concat()
    };
    Filter::ALL.into_iter().flat_map(of).collect()
}

/// The largest difference of two images.
pub fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}
