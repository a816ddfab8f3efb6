//! How the voxels of a volume lie in shared memory, and reading them in place.
//!
//! Slices cut the volume in every direction. In plain rows a plane of constant x touches one cache line per voxel; in
//! bricks of 4 x 4 x 4 voxels (two cache lines) each line serves eight. Measured (`cargo bench -p slice-view-proc --bench
//! layout`): sagittal slices take 0.3 to 0.4 of the time, oblique ones half, frontal ones the same, axial ones 1.6 (0.2 ms). The
//! price in memory is rounding each dimension up to the brick: [`Layout::choose`] takes bricks where that adds at most
//! 4.7 %, and rows elsewhere. Smaller bricks save less and are not chosen.
//!
//! The offset of a voxel is a sum of one term per axis, so a reader needs three small tables and no arithmetic on bricks.

mod identity;
mod labels;
mod voxels;

use geometry::{Ct, Point, VolumeGrid};

pub use identity::{Hasher, Marks, SliceHash, VolumeHash};
pub use labels::LabelMap;
pub use voxels::{ALIGNMENT, Voxels};

const BRICK: [u32; 3] = [4, 4, 4];
const ROWS: [u32; 3] = [1, 1, 1];
/// Most memory that bricks may add, relative to the voxels themselves.
const MAX_PADDING: f64 = 0.047;
/// The most voxels along an axis: a forged header makes no tables larger than 4 MiB.
const MAX_SIDE: u32 = 1 << 20;

/// Where voxel (x, y, z) lies: `table[0][x] + table[1][y] + table[2][z]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    brick: [u32; 3],
    tables: [Vec<u32>; 3],
    stored: u64,
}

/// The offset term of index i along one axis is `(i >> log2_side) * outer + (i & (2^log2_side - 1)) * inner`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Logarithm of the brick's side.
    pub log2_side: u32,
    /// From one brick to the next; 0 where there is only one.
    pub outer: u32,
    /// From one voxel of a brick to the next.
    pub inner: u32,
}

/// Why a layout was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LayoutError {
    /// A brick's side is not one of 1, 2, 4, 8, 16.
    #[error("brick {0:?}: each side must be 1, 2, 4, 8 or 16 voxels")]
    Brick([u32; 3]),
    /// The volume has more voxels than 32-bit offsets reach.
    #[error("{0} stored voxels; at most 4294967295 can be addressed")]
    TooLarge(u64),
    /// An axis has no voxels, or more than any examination.
    #[error("{0:?} voxels; each axis must have 1 to {MAX_SIDE}")]
    Side([u32; 3]),
}

impl Layout {
    /// The layout of a volume of `dims` voxels in bricks of `brick` voxels.
    ///
    /// # Errors
    /// [`LayoutError`].
    pub fn new(dims: [u32; 3], brick: [u32; 3]) -> Result<Self, LayoutError> {
        if brick.iter().any(|&b| !b.is_power_of_two() || b > 16) {
            return Err(LayoutError::Brick(brick));
        }
        if dims.iter().any(|&n| !(1..=MAX_SIDE).contains(&n)) {
            return Err(LayoutError::Side(dims));
        }
        let stored = stored_voxels(dims, brick);
        if stored > u64::from(u32::MAX) {
            return Err(LayoutError::TooLarge(stored));
        }
        let padded: [u64; 3] = std::array::from_fn(|a| u64::from(dims[a].next_multiple_of(brick[a])));
        let [bx, by, bz] = brick.map(u64::from);
        // Strides of one brick along each axis, and of one voxel inside a brick.
        let outer = [bx * by * bz, padded[0] * by * bz, padded[0] * padded[1] * bz];
        let inner = [1, bx, bx * by];
        let tables = std::array::from_fn(|a| {
            let side = u64::from(brick[a]);
            (0..u64::from(dims[a]))
                .map(|i| (i / side * outer[a] + i % side * inner[a]) as u32)
                .collect()
        });
        Ok(Self { brick, tables, stored })
    }

    /// The layout that a loader gives a volume of `dims` voxels.
    ///
    /// # Errors
    /// [`LayoutError::TooLarge`].
    pub fn choose(dims: [u32; 3]) -> Result<Self, LayoutError> {
        let voxels: u64 = dims.iter().map(|&d| u64::from(d)).product();
        let allowed = voxels as f64 * (1.0 + MAX_PADDING);
        let bricks_fit = stored_voxels(dims, BRICK) as f64 <= allowed;
        Self::new(dims, if bricks_fit { BRICK } else { ROWS })
    }

    /// Brick sides, voxels.
    pub fn brick(&self) -> [u32; 3] {
        self.brick
    }

    /// Values in memory, padding of bricks included.
    pub fn stored(&self) -> u64 {
        self.stored
    }

    /// The offset terms along `axis` (0, 1 or 2), one per voxel.
    pub fn table(&self, axis: usize) -> &[u32] {
        &self.tables[axis]
    }

    /// How the terms along `axis` are made.
    pub fn steps(&self, axis: usize) -> Steps {
        let side = self.brick[axis];
        let inner: u32 = self.brick[..axis].iter().product();
        let outer = match side as usize {
            side if side < self.tables[axis].len() => self.tables[axis][side],
            _ => 0,
        };
        Steps {
            log2_side: side.trailing_zeros(),
            outer,
            inner,
        }
    }

    /// The offset of a voxel inside the volume.
    pub fn offset(&self, [x, y, z]: [u32; 3]) -> usize {
        (self.tables[0][x as usize] + self.tables[1][y as usize] + self.tables[2][z as usize]) as usize
    }

    /// Values in memory of one layer of bricks: slices of one layer lie together, layers one after another.
    pub fn layer(&self) -> usize {
        let layers = self.tables[2].len().div_ceil(self.brick[2] as usize);
        (self.stored / layers as u64) as usize
    }

    /// The slices of layer `index`.
    pub fn slices_of_layer(&self, index: usize) -> std::ops::Range<u32> {
        let (side, slices) = (self.brick[2], self.tables[2].len() as u32);
        let first = (index as u32).saturating_mul(side);
        first.min(slices)..first.saturating_add(side).min(slices)
    }

    /// Puts slice `z`, given row by row, into its place in `stored`.
    pub fn scatter(&self, z: u32, slice: &[i16], stored: &mut [i16]) {
        let layer = self.layer();
        let first = (z / self.brick[2]) as usize * layer;
        self.scatter_in_layer(z, slice, &mut stored[first..first + layer]);
    }

    /// The same, with no more than the slice's own layer at hand ([`Layout::layer`] values).
    pub fn scatter_in_layer(&self, z: u32, slice: &[i16], layer: &mut [i16]) {
        let [columns, side] = [self.tables[0].len(), self.brick[1] as usize];
        let within = self.steps(2).inner as usize * (z % self.brick[2]) as usize;
        let bricks = slice.chunks(columns * side).zip(self.tables[1].iter().step_by(side));
        for (rows, &base_y) in bricks {
            let rest = &mut layer[base_y as usize + within..];
            match self.brick {
                BRICK => scatter_fours(rows, columns, rest),
                _ => self.scatter_rows(rows, rest),
            }
        }
    }

    /// Up to a brick's side of rows, by the table.
    fn scatter_rows(&self, rows: &[i16], out: &mut [i16]) {
        for (y, row) in rows.chunks(self.tables[0].len()).enumerate() {
            for (&value, &base_x) in row.iter().zip(&self.tables[0]) {
                out[self.brick[0] as usize * y + base_x as usize] = value;
            }
        }
    }
}

/// Up to four rows into one row of bricks of 4 x 4 x 4: a brick's share of a slice is 32 bytes in a piece.
fn scatter_fours(rows: &[i16], columns: usize, out: &mut [i16]) {
    if rows.len() == 4 * columns {
        let (r0, rest) = rows.split_at(columns);
        let (r1, rest) = rest.split_at(columns);
        let (r2, r3) = rest.split_at(columns);
        let fours = r0.as_chunks::<4>().0.iter().zip(r1.as_chunks::<4>().0);
        let fours = fours.zip(r2.as_chunks::<4>().0.iter().zip(r3.as_chunks::<4>().0));
        for (brick, ((a, b), (c, d))) in out.chunks_mut(64).zip(fours) {
            let place = brick[..16].as_chunks_mut::<4>().0;
            place[0] = *a;
            place[1] = *b;
            place[2] = *c;
            place[3] = *d;
        }
    } else {
        for (y, row) in rows.chunks(columns).enumerate() {
            for (brick, four) in out.chunks_mut(64).zip(row.as_chunks::<4>().0) {
                brick[4 * y..4 * y + 4].copy_from_slice(four);
            }
        }
    }
    let whole = columns / 4 * 4;
    for (y, row) in rows.chunks(columns).enumerate() {
        for (x, &value) in row[whole..].iter().enumerate() {
            out[whole / 4 * 64 + 4 * y + x] = value;
        }
    }
}

fn stored_voxels(dims: [u32; 3], brick: [u32; 3]) -> u64 {
    (0..3).map(|a| u64::from(dims[a].next_multiple_of(brick[a]))).product()
}

/// A volume being read in place: grid, layout and voxels.
#[derive(Debug, Clone, Copy)]
pub struct VolumeView<'a> {
    /// Where the voxels lie in the patient.
    pub grid: &'a VolumeGrid,
    /// Where they lie in memory.
    pub layout: &'a Layout,
    /// The stored values, HU.
    pub voxels: &'a [i16],
    /// The HU of everything outside.
    pub padding_hu: i16,
}

impl VolumeView<'_> {
    /// The HU of one voxel.
    pub fn at(&self, voxel: [u32; 3]) -> i16 {
        self.voxels[self.layout.offset(voxel)]
    }

    /// Writes slice `z` row by row.
    pub fn slice(&self, z: u32, out: &mut [i16]) {
        let columns = self.layout.table(0);
        for (row, y) in out.chunks_mut(columns.len()).zip(self.layout.table(1)) {
            let first = y + self.layout.table(2)[z as usize];
            for (value, x) in row.iter_mut().zip(columns) {
                *value = self.voxels[(first + x) as usize];
            }
        }
    }

    /// The HU of the voxel in which a point lies; `None` outside.
    pub fn nearest(&self, p: Point<Ct>) -> Option<i16> {
        if !self.grid.holds(p) {
            return None;
        }
        let index = (self.grid.voxel_from_ct() * p).mm();
        // The upper border of the last voxel rounds to one behind it.
        let voxel = std::array::from_fn(|axis| (index[axis].round().max(0.0) as u32).min(self.grid.dims()[axis] - 1));
        Some(self.at(voxel))
    }
}

/// A volume in this process's own memory, for tools that work on a file without a run.
#[derive(Debug, Clone)]
pub struct OwnedVolume {
    /// Where the voxels lie in the patient.
    pub grid: VolumeGrid,
    /// Where they lie in memory.
    pub layout: Layout,
    /// The stored values, HU.
    pub voxels: Voxels,
    /// The HU of everything outside.
    pub padding_hu: i16,
    /// The volume's identity.
    pub hash: VolumeHash,
    /// What every image of it must say.
    pub marks: Marks,
}

impl OwnedVolume {
    /// The voxels in place.
    pub fn view(&self) -> VolumeView<'_> {
        VolumeView {
            grid: &self.grid,
            layout: &self.layout,
            voxels: &self.voxels,
            padding_hu: self.padding_hu,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_voxel_has_a_place_of_its_own(dims in prop::array::uniform3(1_u32..12), log2 in prop::array::uniform3(0_u32..4)) {
            let layout = Layout::new(dims, log2.map(|b| 1 << b)).unwrap();
            let mut taken = vec![false; layout.stored() as usize];
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let at = layout.offset([x, y, z]);
                        prop_assert!(!std::mem::replace(&mut taken[at], true));
                        let term = |a: usize, i: u32| {
                            let s = layout.steps(a);
                            (i >> s.log2_side) * s.outer + (i & ((1 << s.log2_side) - 1)) * s.inner
                        };
                        prop_assert_eq!((term(0, x) + term(1, y) + term(2, z)) as usize, at);
                    }
                }
            }
        }

        #[test]
        fn scatter_puts_each_value_where_offset_reads_it(dims in prop::array::uniform3(1_u32..9)) {
            let layout = Layout::choose(dims).unwrap();
            let mut stored = vec![0_i16; layout.stored() as usize];
            let slice: Vec<i16> = (0..dims[0] * dims[1]).map(|i| i as i16 + 1).collect();
            layout.scatter(dims[2] - 1, &slice, &mut stored);
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let expected = slice[(y * dims[0] + x) as usize];
                    prop_assert_eq!(stored[layout.offset([x, y, dims[2] - 1])], expected);
                }
            }
        }
    }

    #[test]
    fn padding_stays_below_its_limit() {
        for dims in [[512, 512, 400], [122, 101, 112], [7, 5, 3], [65, 65, 65], [1, 1, 1]] {
            let layout = Layout::choose(dims).unwrap();
            let voxels: u64 = dims.iter().map(|&d| u64::from(d)).product();
            assert!(layout.stored() as f64 <= 1.047 * voxels as f64, "{dims:?}");
        }
        assert_eq!(Layout::choose([122, 101, 112]).unwrap().brick(), [4, 4, 4]);
    }

    #[test]
    fn hostile_layouts_are_refused() {
        assert!(Layout::new([4, 4, 4], [0, 1, 1]).is_err());
        assert!(Layout::new([4, 4, 4], [3, 1, 1]).is_err());
        assert!(Layout::new([4, 4, 4], [1 << 31, 1, 1]).is_err());
        assert!(Layout::new([16_384, 16_384, 16_384], [4, 4, 4]).is_err());
        // Random bytes in the place of a header: tables of 16 GiB for a volume without a voxel, and a product beyond 64 bits.
        for dims in [[0, u32::MAX, 1], [u32::MAX, 1, 0], [u32::MAX; 3], [1, 1, MAX_SIDE + 1]] {
            assert_eq!(Layout::new(dims, [1; 3]), Err(LayoutError::Side(dims)));
        }
    }
}
