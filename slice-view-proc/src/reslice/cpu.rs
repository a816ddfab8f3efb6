//! The fast CPU back end: fixed-point indices along each row, f32 weights, one thread, no unsafe.
//!
//! Positions are 40-bit fractions of a voxel, so that 4096 steps stay within 4e-9 of a voxel of the exact index; f32
//! indices would be off by up to 3e-5 of a voxel, which is 0.1 HU at the edge of a bone. The border pixels of each row
//! go through the reference.

use bus::scene::Filter;
use bus::volume::VolumeView;
use geometry::SlicePlane;

use super::reference::sample;
use super::{IndexPlane, Resampler};

/// Fraction bits of an index; 63 - 40 bits are left for the voxel number, more than a dimension may have.
const FRACTION_BITS: u32 = 40;
const ONE: f64 = (1_u64 << FRACTION_BITS) as f64;

/// The fast back end on one CPU core.
#[derive(Debug, Default, Clone, Copy)]
pub struct Cpu;

impl Resampler for Cpu {
    fn name(&self) -> &'static str {
        "cpu-f32"
    }

    fn error_bound_hu(&self, filter: Filter, max_abs_hu: f64) -> f64 {
        match filter {
            // The same voxel: see the trait for indices in the middle between two.
            Filter::Nearest => 0.0,
            // Three nested a + (b - a) w: each rounds its product (up to twice the largest value) and its sum, and the
            // weight itself is good to 2^-24. Seven of those half ulp of the largest value bound the sum.
            Filter::Linear => max_abs_hu * f64::from(f32::EPSILON) * 7.0,
        }
    }

    fn reslice(&mut self, volume: &VolumeView<'_>, plane: &SlicePlane, filter: Filter, hu: &mut [f32]) {
        let index = IndexPlane::new(volume, plane);
        let width = plane.size()[0] as usize;
        for (row, line) in hu.chunks_exact_mut(width).enumerate() {
            let start = index.at(0.0, row as f64);
            let inner = inner_span(volume.grid.dims(), start, index.right, width);
            let exact = |column: usize| sample(volume, index.at(column as f64, row as f64), filter) as f32;
            for column in (0..inner.start).chain(inner.end..width) {
                line[column] = exact(column);
            }
            let first = index.at(inner.start as f64, row as f64);
            match filter {
                Filter::Nearest => nearest_row(volume, first, index.right, &mut line[inner]),
                Filter::Linear => linear_row(volume, first, index.right, &mut line[inner]),
            }
        }
    }
}

/// The columns whose index lies at least one step inside the outermost voxel centres, so that all eight neighbours
/// exist whatever the rounding.
fn inner_span(dims: [u32; 3], start: [f64; 3], step: [f64; 3], width: usize) -> std::ops::Range<usize> {
    let (mut from, mut to) = (0.0_f64, width as f64);
    for a in 0..3 {
        let last = f64::from(dims[a]) - 1.0;
        if step[a].abs() < 1e-12 {
            // Constant along the row: inside, or nowhere.
            if !(start[a] >= 1e-6 && start[a] <= last - 1e-6) {
                return 0..0;
            }
            continue;
        }
        let (near, far) = (-start[a] / step[a], (last - start[a]) / step[a]);
        from = from.max(near.min(far) + 1.0);
        to = to.min(near.max(far) - 1.0);
    }
    let from = from.ceil().min(width as f64) as usize;
    let to = to.floor().max(0.0) as usize;
    if from < to { from..to.min(width) } else { 0..0 }
}

fn fixed(index: f64) -> i64 {
    (index * ONE).round() as i64
}

fn linear_row(volume: &VolumeView<'_>, first: [f64; 3], step: [f64; 3], line: &mut [f32]) {
    let (mut at, step) = (first.map(fixed), step.map(fixed));
    let [tx, ty, tz] = [0, 1, 2].map(|a| volume.layout.table(a));
    let voxels = volume.voxels;
    let whole = |v: i64| (v >> FRACTION_BITS) as usize;
    // The upper 24 bits of the fraction: exactly what an f32 holds.
    let weight = |v: i64| ((v >> (FRACTION_BITS - 24)) & 0xff_ffff) as f32 * (1.0 / (1 << 24) as f32);
    let mix = |a: f32, b: f32, w: f32| a + (b - a) * w;
    for value in line {
        let [x, y, z] = at.map(whole);
        let [wx, wy, wz] = at.map(weight);
        let (x0, x1) = (tx[x] as usize, tx[x + 1] as usize);
        let (y0, y1) = (ty[y] as usize, ty[y + 1] as usize);
        let (z0, z1) = (tz[z] as usize, tz[z + 1] as usize);
        let edge = |yz: usize| mix(f32::from(voxels[x0 + yz]), f32::from(voxels[x1 + yz]), wx);
        let near = mix(edge(y0 + z0), edge(y1 + z0), wy);
        let far = mix(edge(y0 + z1), edge(y1 + z1), wy);
        *value = mix(near, far, wz);
        at = std::array::from_fn(|a| at[a] + step[a]);
    }
}

fn nearest_row(volume: &VolumeView<'_>, first: [f64; 3], step: [f64; 3], line: &mut [f32]) {
    let (mut at, step) = (first.map(|v| fixed(v + 0.5)), step.map(fixed));
    let [tx, ty, tz] = [0, 1, 2].map(|a| volume.layout.table(a));
    for value in line {
        let [x, y, z] = at.map(|v| (v >> FRACTION_BITS) as usize);
        *value = f32::from(volume.voxels[(tx[x] + ty[y] + tz[z]) as usize]);
        at = std::array::from_fn(|a| at[a] + step[a]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Reference;
    use super::*;
    use bus::message::VolumeHash;
    use bus::volume::{Layout, OwnedVolume};
    use geometry::{Affine, Direction, Point, Vector, VolumeGrid};
    use proptest::prelude::*;

    /// A volume of noise from -2000 to 2000 HU: the hardest case for an interpolator.
    fn noise(dims: [u32; 3], sheared: bool) -> OwnedVolume {
        let shear = if sheared { 0.35 } else { 0.0 };
        let affine = Affine::from_rows([[0.8, 0.0, 0.0, -20.0], [0.0, 0.9, shear, 10.0], [0.0, 0.0, 1.5, -5.0]]);
        let grid = VolumeGrid::checked(dims.map(i64::from), affine).unwrap();
        let layout = Layout::choose(dims).unwrap();
        let mut voxels = vec![0; layout.stored() as usize];
        let mut state = 1_u64;
        for voxel in &mut voxels {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            *voxel = ((state >> 33) % 4001) as i16 - 2000;
        }
        OwnedVolume {
            grid,
            layout,
            voxels,
            padding_hu: -1024,
            hash: VolumeHash::default(),
        }
    }

    fn plane_at(centre: [f64; 3], normal: [f64; 3], pixel_mm: f64) -> Option<SlicePlane> {
        let into = Vector::new(normal[0], normal[1], normal[2]).direction()?;
        let right = into.cross(Direction::Y).direction()?;
        let down = into.cross(right).direction()?;
        SlicePlane::centred(
            Point::new(centre[0], centre[1], centre[2]),
            [right, down],
            pixel_mm,
            [67, 41],
        )
        .ok()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        #[test]
        fn agrees_with_the_reference(
            centre in prop::array::uniform3(-25.0..35.0), normal in prop::array::uniform3(-1.0..1.0),
            pixel_mm in 0.05..3.0, sheared: bool, thin in 1_u32..4,
        ) {
            let volume = noise([40, 37, thin * 9 - 8], sheared);
            let Some(plane) = plane_at(centre, normal, pixel_mm) else { return Ok(()) };
            for filter in [Filter::Linear, Filter::Nearest] {
                let (mut fast, mut exact) = (vec![0.0; 67 * 41], vec![0.0; 67 * 41]);
                Cpu.reslice(&volume.view(), &plane, filter, &mut fast);
                Reference.reslice(&volume.view(), &plane, filter, &mut exact);
                // Two results in f32, and the index error of 4e-9 voxel times the steepest slope of 4000 HU a voxel.
                let bound = Cpu.error_bound_hu(filter, 2000.0) + Reference.error_bound_hu(filter, 2000.0) + 3.0 * 4000.0 * 4e-9;
                for (a, b) in fast.iter().zip(&exact) {
                    prop_assert!(f64::from((a - b).abs()) <= bound, "{filter:?}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn planes_on_voxel_centres_give_the_voxels() {
        let volume = noise([16, 16, 16], false);
        // Ten columns of one voxel each, about index 7.5: voxels 3 to 12 of row 7 in slice 3.
        let middle = volume.grid.ct_from_voxel() * Point::new(7.5, 7.0, 3.0);
        let plane = SlicePlane::centred(middle, [Direction::X, Direction::Y], 0.8, [10, 1]).unwrap();
        let expected: Vec<f32> = (3..13).map(|x| f32::from(volume.view().at([x, 7, 3]))).collect();
        let back_ends: [&mut dyn Resampler; 2] = [&mut Reference, &mut Cpu];
        for back_end in back_ends {
            for filter in [Filter::Linear, Filter::Nearest] {
                let mut line = vec![0.0; 10];
                back_end.reslice(&volume.view(), &plane, filter, &mut line);
                // The stated bound, and an index off by 4e-9 voxel on three slopes of up to 4000 HU.
                let bound = back_end.error_bound_hu(filter, 2000.0) + 3.0 * 4000.0 * 4e-9;
                for (got, want) in line.iter().zip(&expected) {
                    assert!(
                        f64::from((got - want).abs()) <= bound,
                        "{} {filter:?}: {got} {want}",
                        back_end.name()
                    );
                }
            }
        }
    }

    #[test]
    fn outside_is_padding() {
        let volume = noise([8, 8, 8], false);
        let far = SlicePlane::centred(Point::new(900.0, 0.0, 0.0), [Direction::X, Direction::Y], 1.0, [8, 8]).unwrap();
        let mut hu = vec![0.0; 64];
        Cpu.reslice(&volume.view(), &far, Filter::Linear, &mut hu);
        assert!(hu.iter().all(|&v| v == -1024.0));
    }
}
