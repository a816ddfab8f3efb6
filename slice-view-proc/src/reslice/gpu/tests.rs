//! The card against the CPU. Where there is no card, not even one in software, these tests say so and do nothing.

use std::cell::RefCell;

use bus::message::VolumeHash;
use bus::volume::{Layout, OwnedVolume, Voxels};
use geometry::{Affine, Direction, Point, Vector as Along, VolumeGrid};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use scene::{Minify, Slab, SlabMode};

use super::*;

mod figures;
mod life;

const LARGEST_HU: f64 = 2000.0;

/// A card of any kind, or a word that there is none.
fn card(weights: GpuWeights) -> Option<Gpu> {
    match Gpu::open(Accepted::Any, weights) {
        Ok(gpu) => Some(gpu),
        Err(why) => {
            println!("skipped: {why}");
            None
        }
    }
}

/// A volume of noise from -2000 to 2000 HU: the hardest case for an interpolator.
fn noise(dims: [u32; 3], brick: [u32; 3]) -> OwnedVolume {
    let affine = Affine::from_rows([[0.8, 0.0, 0.0, -20.0], [0.0, 0.9, 0.35, 10.0], [0.0, 0.0, 1.5, -5.0]]);
    let layout = Layout::new(dims, brick).unwrap();
    let mut state = 1_u64;
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    for voxel in &mut *voxels {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        *voxel = ((state >> 33) % 4001) as i16 - 2000;
    }
    OwnedVolume {
        grid: VolumeGrid::checked(dims.map(i64::from), affine).unwrap(),
        layout,
        voxels,
        padding_hu: -1024,
        hash: VolumeHash::default(),
        marks: bus::message::Marks::NONE,
    }
}

/// A plane about the middle of the volume, moved by `off` voxels.
fn plane(volume: &OwnedVolume, off: [f64; 3], normal: [f64; 3], pixel_mm: f64, size: [u32; 2]) -> Option<SlicePlane> {
    let into = Along::new(normal[0], normal[1], normal[2]).direction()?;
    let right = into.cross(Direction::Y).direction()?;
    let down = into.cross(right).direction()?;
    let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * f64::from(volume.grid.dims()[a]) + off[a]);
    let centre = volume.grid.ct_from_voxel() * Point::new(middle[0], middle[1], middle[2]);
    SlicePlane::centred(centre, [right, down], pixel_mm, size).ok()
}

/// Thin slices, slabs, and areas, of every filter.
fn samplings() -> Vec<Sampling> {
    let slab = |mode| {
        Some(Slab {
            mode,
            thickness_mm: 4.0,
        })
    };
    let ways = |filter: Filter| {
        let thin = Sampling::from(filter);
        let area = Sampling {
            minify: Minify::Area,
            ..thin
        };
        [
            thin,
            area,
            Sampling {
                slab: slab(SlabMode::Mean),
                ..thin
            },
            Sampling {
                slab: slab(SlabMode::Maximum),
                ..area
            },
            Sampling {
                slab: slab(SlabMode::Minimum),
                ..thin
            },
        ]
    };
    Filter::ALL.into_iter().flat_map(ways).collect()
}

fn drawn(back_end: &mut dyn Resampler, volume: &OwnedVolume, plane: &SlicePlane, sampling: &Sampling) -> Vec<f32> {
    let [width, height] = plane.size();
    let mut hu = vec![f32::NAN; width as usize * height as usize];
    back_end.reslice(&volume.view(), plane, sampling, &mut hu).unwrap();
    hu
}

/// Whether two images differ by no more than both bounds; of nearest voxels one in a thousand may lie at a tie.
fn compare(gpu: &dyn Resampler, sampling: &Sampling, a: &[f32], b: &[f32]) -> Result<(), TestCaseError> {
    let bounds = gpu.error_bound_hu(sampling, LARGEST_HU) + Cpu::default().error_bound_hu(sampling, LARGEST_HU);
    let off = |(a, b): (&f32, &f32)| f64::from((a - b).abs());
    let far = a
        .iter()
        .zip(b)
        .map(off)
        .filter(|off| *off > bounds || off.is_nan())
        .count();
    let allowed = if sampling.filter == Filter::Nearest {
        a.len() / 1000
    } else {
        0
    };
    let worst = a.iter().zip(b).map(off).fold(0.0, f64::max);
    prop_assert!(
        far <= allowed,
        "{sampling:?}: {far} pixels beyond {bounds}, worst {worst}"
    );
    Ok(())
}

/// Draws random planes of every sampling on both back ends.
fn agree(weights: GpuWeights, volume: &OwnedVolume, cases: u32) {
    let Some(mut gpu) = card(weights) else { return };
    let samplings = samplings();
    let mut cpu = Cpu::default();
    gpu.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
    cpu.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
    let back_ends = RefCell::new((gpu, cpu));
    let mut runner = TestRunner::new(ProptestConfig::with_cases(cases));
    let planes = (
        prop::array::uniform3(-20.0..20.0),
        prop::array::uniform3(-1.0..1.0),
        0.05..3.0,
        0..samplings.len(),
    );
    let planes = (planes, 1_u32..90, 1_u32..60);
    let result = runner.run(&planes, |((off, normal, pixel_mm, which), width, height)| {
        let Some(plane) = plane(volume, off, normal, pixel_mm, [width, height]) else {
            return Ok(());
        };
        let (sampling, (gpu, cpu)) = (&samplings[which], &mut *back_ends.borrow_mut());
        let (a, b) = (
            drawn(gpu, volume, &plane, sampling),
            drawn(cpu, volume, &plane, sampling),
        );
        compare(gpu, sampling, &a, &b)
    });
    result.unwrap();
}

#[test]
fn agrees_with_the_cpu_on_random_planes() {
    agree(GpuWeights::Exact, &noise([40, 37, 19], [4, 4, 4]), 150);
}

#[test]
fn the_sampler_agrees_within_its_bound() {
    agree(GpuWeights::Sampler, &noise([40, 37, 19], [1, 1, 1]), 40);
}

#[test]
fn small_volumes_agree() {
    for dims in [[1, 1, 1], [2, 2, 2], [1, 23, 17], [23, 1, 17], [23, 17, 1], [3, 2, 9]] {
        agree(GpuWeights::Exact, &noise(dims, [1, 1, 1]), 40);
        agree(GpuWeights::Sampler, &noise(dims, [1, 1, 1]), 5);
    }
}

#[test]
fn images_of_every_size_agree() {
    let Some(mut gpu) = card(GpuWeights::Exact) else { return };
    let (volume, mut cpu, sampling) = (
        noise([64, 64, 32], [4, 4, 4]),
        Cpu::default(),
        Sampling::from(Filter::Linear),
    );
    gpu.prepare(&volume.view(), &[sampling], &mut || {}).unwrap();
    for size in [[1, 1], [1, 700], [700, 1], [8, 8], [9, 7], [1024, 1024], [3000, 1100]] {
        let plane = plane(&volume, [0.3; 3], [0.2, 0.5, 1.0], 0.04, size).unwrap();
        let (a, b) = (
            drawn(&mut gpu, &volume, &plane, &sampling),
            drawn(&mut cpu, &volume, &plane, &sampling),
        );
        compare(&gpu, &sampling, &a, &b).unwrap();
    }
}

#[test]
fn extreme_pixels_agree() {
    let Some(mut gpu) = card(GpuWeights::Exact) else { return };
    let (volume, mut cpu) = (noise([40, 37, 19], [4, 4, 4]), Cpu::default());
    let samplings = [Filter::Linear, Filter::Cubic].map(|filter| Sampling {
        minify: Minify::Area,
        ..filter.into()
    });
    gpu.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
    cpu.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
    for sampling in samplings {
        for pixel_mm in [1e-6, 1e-3, 10.0, 1e3] {
            let plane = plane(&volume, [0.3; 3], [0.2, 0.5, 1.0], pixel_mm, [5, 4]).unwrap();
            let (a, b) = (
                drawn(&mut gpu, &volume, &plane, &sampling),
                drawn(&mut cpu, &volume, &plane, &sampling),
            );
            compare(&gpu, &sampling, &a, &b).unwrap();
        }
    }
}

#[test]
fn outside_is_padding() {
    let Some(mut gpu) = card(GpuWeights::Exact) else { return };
    let (volume, samplings) = (noise([8, 8, 8], [4, 4, 4]), samplings());
    gpu.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
    for off in [60.0, 1e6] {
        let far = plane(&volume, [off, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, [8, 8]).unwrap();
        for sampling in &samplings {
            assert!(drawn(&mut gpu, &volume, &far, sampling).iter().all(|&v| v == -1024.0));
        }
    }
}

#[test]
fn a_volume_or_filter_that_was_not_prepared_is_refused() {
    let Some(mut gpu) = card(GpuWeights::Exact) else { return };
    let (volume, other) = (noise([8, 8, 8], [4, 4, 4]), noise([8, 8, 8], [1, 1, 1]));
    let plane = plane(&volume, [0.0; 3], [0.0, 0.0, 1.0], 1.0, [4, 4]).unwrap();
    let mut hu = [0.0; 16];
    gpu.prepare(&volume.view(), &[Filter::Linear.into()], &mut || {})
        .unwrap();
    let mut draw = |volume: &OwnedVolume, filter: Filter| gpu.reslice(&volume.view(), &plane, &filter.into(), &mut hu);
    assert_eq!(draw(&volume, Filter::Linear), Ok(()));
    assert_eq!(
        draw(&volume, Filter::Cubic),
        Err(ResliceError::NotPrepared(Filter::Cubic))
    );
    assert_eq!(
        draw(&other, Filter::Linear),
        Err(ResliceError::NotPrepared(Filter::Linear))
    );
}

#[test]
fn says_what_it_takes_and_how_long() {
    let Some(mut gpu) = card(GpuWeights::Exact) else { return };
    let volume = noise([40, 37, 19], [4, 4, 4]);
    assert!(gpu.name().starts_with("gpu exact weights: "), "{}", gpu.name());
    assert_eq!(gpu.bytes(), 0);
    gpu.prepare(
        &volume.view(),
        &[Filter::Linear.into(), Filter::BSpline.into()],
        &mut || {},
    )
    .unwrap();
    assert_eq!(gpu.bytes(), 40 * 37 * 19 * (2 + 4));
    let plane = plane(&volume, [0.0; 3], [0.0, 0.0, 1.0], 0.5, [64, 64]).unwrap();
    drawn(&mut gpu, &volume, &plane, &Filter::Linear.into());
    assert!(gpu.bytes() > 40 * 37 * 19 * 6 + 64 * 64 * 8);
    let Timings { upload_ns, run_ns, .. } = gpu.timings();
    assert!(upload_ns > 0 && run_ns > 0);
}
