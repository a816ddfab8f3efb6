//! The CT of a formula, in a slice through tissue that a formula moved: no pixel is further from the formula than the bounds say.

use bus::message::{Marks, VolumeHash};
use bus::volume::{Layout, OwnedVolume, Voxels};
use chance::SplitMix64;
use geometry::{Affine, VolumeGrid};
use scene::Filter;

use super::fields::{bent, unbent};
use super::stage::{Mesh, axes, block, draw, in_box, place, plane};
use crate::reslice::{Cpu, Resampler};
use crate::warp::{Pixel, Warp};

/// Waves of 400 HU, 30 mm long along each axis.
const HU: f64 = 400.0;
const WAVE: f64 = std::f64::consts::TAU / 30.0;
const VOXEL_MM: f64 = 1.0;

fn hu(place: [f64; 3]) -> f64 {
    HU * place.iter().map(|x| (WAVE * x).sin()).product::<f64>()
}

fn volume() -> OwnedVolume {
    const N: u32 = 49;
    let layout = Layout::new([N; 3], [4, 4, 4]).unwrap();
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    for k in 0..N.pow(3) {
        let voxel = [k % N, k / N % N, k / (N * N)];
        let at = layout.offset(voxel);
        voxels[at] = hu(voxel.map(|i| f64::from(i) * VOXEL_MM - 24.0)).round() as i16;
    }
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, -24.0], [0.0, 1.0, 0.0, -24.0], [0.0, 0.0, 1.0, -24.0]]);
    OwnedVolume {
        grid: VolumeGrid::checked([i64::from(N); 3], affine).unwrap(),
        layout,
        voxels,
        padding_hu: -1024,
        hash: VolumeHash::default(),
        marks: Marks::NONE,
    }
}

#[test]
fn a_slice_of_a_formula_through_moved_tissue_is_within_its_bound() {
    let (volume, mut warp, mut rng) = (volume(), Warp::default(), SplitMix64::new(4));
    let mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), bent);
    let mut cpu = Cpu::default();
    // Linear interpolation along each of three axes: an eighth of the square of the step times the second derivative; and whole HU.
    let volume_hu = 3.0 / 8.0 * (VOXEL_MM * WAVE).powi(2) * HU + 0.5;
    let steepest = 3.0_f64.sqrt() * HU * WAVE;
    for piece in [5.0, 2.5, 0.625] {
        let shape = mesh.shape(in_box([0.0; 3], 18.0), piece);
        let (mut worst, mut seen) = (0.0_f64, 0);
        for _ in 0..10 {
            let plane = plane([0; 3].map(|_| rng.around(0.0, 8.0)), axes(&mut rng), 0.7, [64, 64]);
            let warped = draw(&mut warp, &plane, &shape, &mesh);
            let mut found = vec![0.0; warped.rest.len()];
            cpu.reslice_at(&volume.view(), &warped.rest, Filter::Linear, &mut found)
                .unwrap();
            let bound = volume_hu + steepest * warped.error_mm + cpu.error_bound_hu(&Filter::Linear.into(), HU) + 0.01;
            for k in (0..found.len()).filter(|k| warped.pixels[*k] == Pixel::Inside(0)) {
                let off = (f64::from(found[k]) - hu(unbent(place(&plane, k)))).abs();
                assert!(off <= bound, "{piece} {k}: {off} > {bound}");
                (worst, seen) = (worst.max(off), seen + 1);
            }
        }
        println!("pieces of {piece} mm: {worst:.2} HU");
        // Of the smallest pieces what is left is the volume's.
        assert!(
            seen > 5_000 && (piece > 1.0 || worst < 1.2 * volume_hu),
            "{seen} {worst}"
        );
    }
}
