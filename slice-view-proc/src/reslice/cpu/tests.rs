//! The fast back end against the reference and against itself without vector instructions.

use super::super::Reference;
use super::*;
use bus::message::VolumeHash;
use bus::volume::{Layout, OwnedVolume, Voxels};
use geometry::{Affine, Direction, Point, Vector as Way, VolumeGrid};
use proptest::prelude::*;
use scene::{Minify, Slab, SlabMode};

const SIZE: [u32; 2] = [67, 41];
const LARGEST_HU: f64 = 2000.0;

/// A volume of noise from -2000 to 2000 HU: the hardest case for an interpolator.
fn noise(dims: [u32; 3], brick: [u32; 3], sheared: bool) -> OwnedVolume {
    let shear = if sheared { 0.35 } else { 0.0 };
    let affine = Affine::from_rows([[0.8, 0.0, 0.0, -20.0], [0.0, 0.9, shear, 10.0], [0.0, 0.0, 1.5, -5.0]]);
    let layout = Layout::new(dims, brick).unwrap();
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    let mut state = 1_u64;
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

fn plane_at(centre: [f64; 3], normal: [f64; 3], pixel_mm: f64) -> Option<SlicePlane> {
    let into = Way::new(normal[0], normal[1], normal[2]).direction()?;
    let right = into.cross(Direction::Y).direction()?;
    let down = into.cross(right).direction()?;
    let centre = Point::new(centre[0], centre[1], centre[2]);
    SlicePlane::centred(centre, [right, down], pixel_mm, SIZE).ok()
}

fn drawn(back_end: &mut dyn Resampler, volume: &OwnedVolume, plane: &SlicePlane, sampling: &Sampling) -> Vec<f32> {
    let [width, height] = plane.size();
    let mut hu = vec![f32::NAN; width as usize * height as usize];
    back_end.prepare(&volume.view(), &[*sampling], &mut || {}).unwrap();
    back_end.reslice(&volume.view(), plane, sampling, &mut hu).unwrap();
    hu
}

/// Thin slices, slabs, and areas, in turn.
fn samplings(filter: Filter) -> Vec<Sampling> {
    let slab = |mode| {
        Some(Slab {
            mode,
            thickness_mm: 4.0,
        })
    };
    let thin = Sampling::from(filter);
    vec![
        thin,
        Sampling {
            minify: Minify::Area,
            ..thin
        },
        Sampling {
            slab: slab(SlabMode::Mean),
            ..thin
        },
        Sampling {
            slab: slab(SlabMode::Maximum),
            minify: Minify::Area,
            ..thin
        },
        Sampling {
            slab: slab(SlabMode::Minimum),
            ..thin
        },
    ]
}

/// Both back ends' bounds.
fn bound(sampling: &Sampling) -> f64 {
    Cpu::default().error_bound_hu(sampling, LARGEST_HU) + Reference::default().error_bound_hu(sampling, LARGEST_HU)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]
    #[test]
    fn agrees_with_the_reference(
        centre in prop::array::uniform3(-25.0..35.0), normal in prop::array::uniform3(-1.0..1.0),
        pixel_mm in 0.05..3.0, sheared: bool, thin in 1_u32..4, which in 0_usize..30,
    ) {
        let volume = noise([40, 37, thin * 9 - 8], [4, 4, 4], sheared);
        let Some(plane) = plane_at(centre, normal, pixel_mm) else { return Ok(()) };
        let sampling = samplings(Filter::ALL[which % 6])[which / 6];
        let fast = drawn(&mut Cpu::default(), &volume, &plane, &sampling);
        let exact = drawn(&mut Reference::default(), &volume, &plane, &sampling);
        for (a, b) in fast.iter().zip(&exact) {
            prop_assert!(f64::from((a - b).abs()) <= bound(&sampling), "{sampling:?}: {a} {b}");
        }
    }

    #[test]
    fn vector_code_gives_the_portable_bits(
        centre in prop::array::uniform3(-25.0..35.0), normal in prop::array::uniform3(-1.0..1.0),
        pixel_mm in 0.02..30.0, brick in 0_usize..4, thin in 1_u32..4, which in 0_usize..30,
    ) {
        let brick = [[1, 1, 1], [4, 4, 4], [4, 4, 2], [16, 2, 1]][brick];
        let volume = noise([40, 37, thin * 9 - 8], brick, true);
        let Some(plane) = plane_at(centre, normal, pixel_mm) else { return Ok(()) };
        let sampling = samplings(Filter::ALL[which % 6])[which / 6];
        let bits = |hu: Vec<f32>| -> Vec<u32> { hu.into_iter().map(f32::to_bits).collect() };
        let fast = bits(drawn(&mut Cpu::default(), &volume, &plane, &sampling));
        let portable = bits(drawn(&mut Cpu::portable(), &volume, &plane, &sampling));
        prop_assert_eq!(fast, portable);
    }
}

/// Single places, some of them outside and some no numbers.
#[test]
fn places_in_any_order_agree_with_the_reference() {
    let volume = noise([40, 37, 29], [4, 4, 4], true);
    let mut random = chance::SplitMix64::new(5);
    let (low, high) = volume.grid.bounds();
    let (low, high) = (low.mm(), high.mm());
    let mut one = |_| [0, 1, 2].map(|a| random.around(0.5 * (low[a] + high[a]), 0.6 * (high[a] - low[a])) as f32);
    let mut places: Vec<[f32; 3]> = (0..20_000).map(&mut one).collect();
    places[7] = [f32::NAN, 0.0, 0.0];
    places[8] = [0.0, f32::INFINITY, 0.0];
    for filter in Filter::ALL {
        let mut values = [0, 1, 2].map(|_| vec![f32::NAN; places.len()]);
        let [fast, portable, exact] = &mut values;
        let mut reference = Reference::default();
        reference.prepare(&volume.view(), &[filter.into()], &mut || {}).unwrap();
        reference.reslice_at(&volume.view(), &places, filter, exact).unwrap();
        for (mut cpu, found) in [(Cpu::default(), fast), (Cpu::portable(), portable)] {
            cpu.prepare(&volume.view(), &[filter.into()], &mut || {}).unwrap();
            cpu.reslice_at(&volume.view(), &places, filter, found).unwrap();
        }
        let [fast, portable, exact] = values;
        assert!(fast.iter().zip(&portable).all(|(a, b)| a.to_bits() == b.to_bits()));
        let bound = bound(&filter.into());
        for (k, (a, b)) in fast.iter().zip(&exact).enumerate() {
            assert!(f64::from((a - b).abs()) <= bound, "{filter:?} {k}: {a} {b}");
        }
        assert_eq!(fast[7..9], [-1024.0; 2]);
        assert!(fast.iter().filter(|hu| **hu != -1024.0).count() > 8_000);
    }
}

/// Planes along the axes are summed in another order than the others: axis by axis.
#[test]
fn planes_along_the_axes_agree_with_both() {
    let volume = noise([40, 37, 29], [4, 4, 4], false);
    let centre = volume.grid.centre().mm().map(|c| c + 0.0137);
    let axes = [Direction::X, Direction::Y, Direction::Z];
    for (right, down) in [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)] {
        for (sign, pixel_mm) in [(1.0, 0.31), (-1.0, 2.3)] {
            let right = if sign > 0.0 { axes[right] } else { -axes[right] };
            let at = Point::new(centre[0], centre[1], centre[2]);
            let plane = SlicePlane::centred(at, [right, axes[down]], pixel_mm, SIZE).unwrap();
            for sampling in Filter::ALL.into_iter().flat_map(samplings) {
                let fast = drawn(&mut Cpu::default(), &volume, &plane, &sampling);
                let portable = drawn(&mut Cpu::portable(), &volume, &plane, &sampling);
                assert!(
                    fast.iter().zip(&portable).all(|(a, b)| a.to_bits() == b.to_bits()),
                    "{sampling:?}"
                );
                let exact = drawn(&mut Reference::default(), &volume, &plane, &sampling);
                for (a, b) in fast.iter().zip(&exact) {
                    assert!(f64::from((a - b).abs()) <= bound(&sampling), "{sampling:?}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn planes_on_voxel_centres_give_the_voxels() {
    let volume = noise([16, 16, 16], [4, 4, 4], false);
    // Ten columns of one voxel each, about index 7.5: voxels 3 to 12 of row 7 in slice 3.
    let middle = volume.grid.ct_from_voxel() * Point::new(7.5, 7.0, 3.0);
    let plane = SlicePlane::centred(middle, [Direction::X, Direction::Y], 0.8, [10, 1]).unwrap();
    let expected: Vec<f32> = (3..13).map(|x| f32::from(volume.view().at([x, 7, 3]))).collect();
    for filter in Filter::ALL {
        let sampling = filter.into();
        let back_ends: [&mut dyn Resampler; 2] = [&mut Reference::default(), &mut Cpu::default()];
        for back_end in back_ends {
            let line = drawn(back_end, &volume, &plane, &sampling);
            for (got, want) in line.iter().zip(&expected) {
                let off = f64::from((got - want).abs());
                assert!(off <= bound(&sampling), "{} {filter:?}: {got} {want}", back_end.name());
            }
        }
    }
}

#[test]
fn outside_is_padding() {
    let volume = noise([8, 8, 8], [4, 4, 4], false);
    let far = SlicePlane::centred(Point::new(900.0, 0.0, 0.0), [Direction::X, Direction::Y], 1.0, [8, 8]).unwrap();
    for filter in Filter::ALL {
        for sampling in samplings(filter) {
            let hu = drawn(&mut Cpu::default(), &volume, &far, &sampling);
            assert!(hu.iter().all(|&v| v == -1024.0));
        }
    }
}

#[test]
fn filters_that_were_not_prepared_are_refused() {
    let volume = noise([8, 8, 8], [4, 4, 4], false);
    let plane = plane_at([0.0; 3], [0.0, 0.0, 1.0], 1.0).unwrap();
    let mut hu = vec![0.0; (SIZE[0] * SIZE[1]) as usize];
    for filter in [Filter::BSpline, Filter::Sinc3, Filter::Sinc5] {
        let refused = Cpu::default().reslice(&volume.view(), &plane, &filter.into(), &mut hu);
        assert_eq!(refused, Err(ResliceError::NotPrepared(filter)));
        let refused = Cpu::default().reslice_at(&volume.view(), &[[0.0; 3]], filter, &mut hu);
        assert_eq!(refused, Err(ResliceError::NotPrepared(filter)));
    }
}

#[test]
fn coefficients_of_one_volume_are_not_taken_for_another_of_its_layout() {
    let (one, other) = (noise([8, 8, 8], [4, 4, 4], false), noise([8, 8, 8], [4, 4, 4], false));
    let plane = plane_at([0.0; 3], [0.0, 0.0, 1.0], 1.0).unwrap();
    let mut hu = vec![0.0; (SIZE[0] * SIZE[1]) as usize];
    let (sampling, mut cpu) = (Filter::BSpline.into(), Cpu::default());
    cpu.prepare(&one.view(), &[sampling], &mut || {}).unwrap();
    assert_eq!(cpu.reslice(&one.view(), &plane, &sampling, &mut hu), Ok(()));
    let refused = cpu.reslice(&other.view(), &plane, &sampling, &mut hu);
    assert_eq!(refused, Err(ResliceError::NotPrepared(Filter::BSpline)));
}
