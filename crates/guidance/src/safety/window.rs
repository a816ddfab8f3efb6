//! Some slices of a label map, with a rim of what is no voxel around them.

use super::block::SIDE;

/// What stands where the map has no voxel: no label, and unlike all of them, so that a voxel at the border is a boundary voxel.
pub(super) const OUTSIDE: i16 = -1;

/// Slices held: those of a layer of blocks, and one on either side.
const SLOTS: usize = SIDE + 2;

/// A layer of blocks and the voxels around it.
pub(super) struct Window {
    labels: Vec<i16>,
    /// Voxels of the map along x and y.
    size: [usize; 2],
    /// From a voxel to its neighbour along x, y and z.
    strides: [usize; 3],
    /// Slices held.
    filled: usize,
}

/// Eight labels along x.
type Row = [i16; SIDE];

impl Window {
    /// Blocks that hold `voxels` in a row.
    pub(super) fn blocks(voxels: usize) -> usize {
        voxels.div_ceil(SIDE)
    }

    pub(super) fn new(size: [usize; 2]) -> Self {
        let [width, height] = size.map(|n| Self::blocks(n) * SIDE + 2);
        Self {
            labels: vec![OUTSIDE; width * height * SLOTS],
            size,
            strides: [1, width, width * height],
            // Before the first slice there is none.
            filled: 1,
        }
    }

    /// Takes the next slice, x fastest. `true` once a layer and the slice above it are there.
    pub(super) fn take(&mut self, slice: &[i16]) -> bool {
        let slot = self.filled * self.strides[2];
        for (y, row) in slice.chunks_exact(self.size[0]).enumerate() {
            let at = slot + (y + 1) * self.strides[1] + 1;
            self.labels[at..at + row.len()].copy_from_slice(row);
        }
        self.filled += 1;
        self.filled == SLOTS
    }

    /// After the last slice there is none. `true` where slices are left that no layer held.
    pub(super) fn close(&mut self) -> bool {
        let left = self.filled > 1;
        self.labels[self.filled * self.strides[2]..].fill(OUTSIDE);
        left
    }

    /// Forgets the layer: its last slice and the one above it are the first two of the next.
    pub(super) fn next_layer(&mut self) {
        self.labels.copy_within((SLOTS - 2) * self.strides[2].., 0);
        self.filled = 2;
    }

    fn row(&self, at: usize) -> Row {
        // A slice of known length is copied as one register.
        let mut row = [OUTSIDE; SIDE];
        row.copy_from_slice(&self.labels[at..at + SIDE]);
        row
    }

    /// Where the row y of slice z of a block begins.
    fn start(&self, block: [usize; 2], y: usize, z: usize) -> usize {
        let [x, y] = [block[0] * SIDE, block[1] * SIDE + y];
        (z + 1) * self.strides[2] + (y + 1) * self.strides[1] + x + 1
    }

    /// Whether every voxel of a block is background.
    pub(super) fn is_background(&self, block: [usize; 2]) -> bool {
        (0..SIDE).all(|z| (0..SIDE).all(|y| self.row(self.start(block, y, z)) == [0; SIDE]))
    }

    /// The labels of a row of a block, and which of them have a neighbour of another label, as bits.
    pub(super) fn look(&self, block: [usize; 2], y: usize, z: usize) -> (Row, u8) {
        let at = self.start(block, y, z);
        let row = self.row(at);
        let mut other = [false; SIDE];
        for stride in self.strides {
            for neighbours in [self.row(at - stride), self.row(at + stride)] {
                for k in 0..SIDE {
                    other[k] |= neighbours[k] != row[k];
                }
            }
        }
        let bits = other.iter().rev().fold(0, |bits, &is| bits << 1 | u8::from(is));
        (row, bits)
    }
}
