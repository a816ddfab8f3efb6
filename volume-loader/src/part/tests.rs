use super::*;
use crate::phantom_source::PhantomSource;
use bus::volume::Layout;
use proptest::prelude::*;

/// Slices by formula, apart or as a stream.
struct Formula {
    grid: VolumeGrid,
    turn: Turn,
    apart: bool,
}

const PADDING: i16 = -2000;

fn hu([x, y, z]: [u32; 3]) -> i16 {
    match (x * 7 + y * 31 + z * 101) % 97 {
        0 => PADDING,
        n => n as i16 * 10 - 300,
    }
}

impl Formula {
    fn boxed(dims: [u32; 3], apart: bool) -> Box<dyn VoxelSource> {
        let rows = [[0.7, 0.0, 0.0, -30.0], [0.0, 0.0, 1.5, 12.0], [0.0, -0.8, 0.4, 7.0]];
        Box::new(Self {
            grid: VolumeGrid::checked(dims.map(i64::from), Affine::from_rows(rows)).unwrap(),
            turn: Turn::default(),
            apart,
        })
    }
    fn slice(&self, k: u32, out: &mut [i16]) {
        let columns = self.grid.dims()[0];
        for (i, v) in (0..).zip(out) {
            *v = hu([i % columns, i / columns, k]);
        }
    }
}

impl VoxelSource for Formula {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }
    fn padding_hu(&self) -> i16 {
        PADDING
    }
    fn describe(&self) -> String {
        "formula".to_owned()
    }
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.grid, k, out)?;
        self.slice(k, out);
        Ok(())
    }
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.grid)?;
        Ok(Conversion::default())
    }
    fn slices(&self) -> Option<&dyn SliceReader> {
        self.apart.then_some(self as &dyn SliceReader)
    }
}

impl SliceReader for Formula {
    fn read(&self, k: u32, out: &mut [i16], _: &mut Scratch) -> Result<Conversion, ReadError> {
        self.slice(k, out);
        Ok(Conversion::default())
    }
}

/// Every voxel, as the loader reads it.
fn read(part: &mut dyn VoxelSource) -> (Vec<i16>, crate::Filled) {
    let dims = part.grid().dims();
    let layout = Layout::new(dims, [1; 3]).unwrap();
    let mut stored = vec![0; layout.stored() as usize];
    let filled = crate::fill(part, &layout, &mut stored, |_| true).unwrap();
    (stored, filled)
}

/// The mean of a block straight from the formula.
fn block_mean(first: [u32; 3], block: [u32; 3]) -> i16 {
    let range = |a: usize| first[a]..first[a] + block[a];
    let (mut n, mut sum) = (0.0, 0.0);
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                if hu([x, y, z]) != PADDING {
                    n += 1.0;
                    sum += f64::from(hu([x, y, z]));
                }
            }
        }
    }
    if n == 0.0 { PADDING } else { (sum / n).round() as i16 }
}

proptest! {
    #[test]
    fn a_part_is_the_means_of_its_blocks_in_their_places(
        dims in prop::array::uniform3(4_u32..12),
        first in prop::array::uniform3(0_u32..3),
        block in prop::array::uniform3(1_u32..4),
        apart: bool,
    ) {
        let end: [u32; 3] = std::array::from_fn(|a| (first[a] + block[a] + 1).min(dims[a]));
        prop_assume!((0..3).all(|a| end[a] - first[a] >= block[a]));
        let region = Region::BoxVoxels([first, end]);
        let whole = Formula::boxed(dims, apart);
        let ct_from_voxel = whole.grid().ct_from_voxel();
        let mut part = Part::new(whole, Some(&region), block).unwrap();
        let [nx, ny, nz] = part.grid().dims();
        let (voxels, _) = read(&mut part);
        for z in 0..nz { for y in 0..ny { for x in 0..nx {
            let at: [u32; 3] = std::array::from_fn(|a| first[a] + [x, y, z][a] * block[a]);
            let i = ((z * ny + y) * nx + x) as usize;
            prop_assert_eq!(voxels[i], block_mean(at, block));
            let middle: [f64; 3] = std::array::from_fn(|a| f64::from(at[a]) + 0.5 * f64::from(block[a] - 1));
            let place = ct_from_voxel * Point::<Voxel>::new(middle[0], middle[1], middle[2]);
            let found = part.grid().ct_from_voxel() * Point::<Voxel>::new(f64::from(x), f64::from(y), f64::from(z));
            // A few roundings of coordinates below 64 mm.
            prop_assert!(place.distance(found) < 1e-13);
        } } }
    }

    #[test]
    fn streams_and_slices_apart_give_the_same_volume(dims in prop::array::uniform3(2_u32..9), block in 1_u32..3) {
        let region = Region::BoxVoxels([[1; 3], dims]);
        prop_assume!(dims.iter().all(|d| *d > block));
        let read_as = |apart| {
            read(&mut Part::new(Formula::boxed(dims, apart), Some(&region), [block; 3]).unwrap())
        };
        prop_assert_eq!(read_as(true), read_as(false));
    }
}

#[test]
fn a_box_in_mm_holds_every_point_of_it_and_no_slice_more_than_needed() {
    let whole = Formula::boxed([40, 40, 40], true);
    let (low, high) = (Point::new(-20.3, 20.0, -5.0), Point::new(-10.1, 33.0, 2.0));
    let [first, end] = bounds::of(&Region::BoxMm([high, low]), whole.grid()).unwrap();
    for corner in [low, high] {
        let voxel = (whole.grid().voxel_from_ct() * corner).mm();
        assert!((0..3).all(|a| f64::from(first[a]) <= voxel[a] && voxel[a] <= f64::from(end[a] - 1)));
    }
    // x: -20.3 and -10.1 mm are voxels 13.86 and 28.43.
    assert_eq!([first[0], end[0]], [13, 30]);
}

#[test]
fn margins_hold_the_points() {
    let whole = Formula::boxed([40, 40, 40], true);
    let points = vec![Point::new(-20.0, 30.0, 0.0)];
    let region = Region::Around { points, margin_mm: 3.5 };
    let by_hand = Region::BoxMm([Point::new(-23.5, 26.5, -3.5), Point::new(-16.5, 33.5, 3.5)]);
    assert_eq!(bounds::of(&region, whole.grid()), bounds::of(&by_hand, whole.grid()));
}

#[test]
fn what_cannot_be_cut_is_refused_by_name() {
    let part = |region, block| {
        Part::new(Formula::boxed([5, 6, 7], true), Some(&region), block)
            .err()
            .unwrap()
    };
    let far = Region::BoxMm([Point::new(1e4, 0.0, 0.0), Point::new(1.1e4, 1.0, 1.0)]);
    assert!(matches!(part(far, [1; 3]), RegionError::Outside { .. }));
    let none = Region::Around {
        points: Vec::new(),
        margin_mm: 5.0,
    };
    assert_eq!(part(none, [1; 3]), RegionError::NoTargets);
    let beyond = Region::BoxVoxels([[0; 3], [5, 6, 8]]);
    assert!(matches!(part(beyond, [1; 3]), RegionError::Voxels { .. }));
    let thin = Region::BoxVoxels([[0; 3], [5, 6, 1]]);
    assert_eq!(
        part(thin, [1, 1, 2]),
        RegionError::Block {
            axis: 2,
            voxels: 1,
            block: 2
        }
    );
}

#[test]
fn marks_and_words_say_what_was_done() {
    let mut half = Part::new(Formula::boxed([8, 8, 8], true), None, [2; 3]).unwrap();
    assert_eq!(half.marks(), Marks::DOWNSAMPLED);
    assert!(half.describe().contains("2 x 2 x 2 voxels made one: 4 x 4 x 4"));
    read(&mut half);
    assert!(half.remarks()[0].contains("HU (rms)"), "{:?}", half.remarks());
    let cut = Part::new(
        Formula::boxed([8, 8, 8], true),
        Some(&Region::BoxVoxels([[1; 3], [8; 3]])),
        [1; 3],
    )
    .unwrap();
    assert_eq!(cut.marks(), Marks::PART);
    assert!(cut.describe().contains("only voxels [1, 1, 1] to [7, 7, 7]"));
    assert!(cut.remarks().is_empty());
}

#[test]
fn the_loss_is_the_distance_from_the_mean() {
    let mut blocks = Loss::default();
    let voxels = [10_i64, 20, 60];
    let sums = blocks::Sums::of(&voxels);
    assert_eq!(blocks.mean(sums), Some(30));
    // Distances 20, 10, 30.
    assert!((blocks.rms_hu() - (1400.0_f64 / 3.0).sqrt()).abs() < 1e-12);
}

#[test]
fn a_quarter_of_the_patient_looks_like_the_patient() {
    let source = |spacing: [f64; 3]| Box::new(PhantomSource::new(1, spacing).unwrap());
    let mut joined = Part::new(source([6.0; 3]), None, [2; 3]).unwrap();
    let (voxels, _) = read(&mut joined);
    let phantom = phantom::Phantom::new(1);
    let [nx, ny, _] = joined.grid().dims();
    let near = voxels.iter().zip(0_u32..).filter(|&(&v, i)| {
        let at = [i % nx, i / nx % ny, i / nx / ny].map(f64::from);
        let place = joined.grid().ct_from_voxel() * Point::<Voxel>::new(at[0], at[1], at[2]);
        (f64::from(v) - phantom.hu(place)).abs() < 150.0
    });
    // Voxels of 12 mm at borders of organs differ; most of the body does not lie at a border.
    assert!(near.count() as f64 > 0.85 * voxels.len() as f64);
}
