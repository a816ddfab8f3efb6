//! The voxels of one label in one block of 8 x 8 x 8.

/// Voxels along each side of a block.
pub(super) const SIDE: usize = 8;

/// Voxels of a block as bits: x is the bit in a byte, y the byte in a word, z the word.
pub(super) type Bits = [u64; SIDE];

/// The voxels of one label in one block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    /// Which block along x, y and z.
    pub(super) at: [u16; 3],
    /// All of them.
    pub(super) all: Bits,
    /// Those with one of their six neighbours of another label, or at the map's border.
    pub(super) boundary: Bits,
}

/// The number of voxels.
pub(super) fn count(bits: &Bits) -> u64 {
    bits.iter().map(|word| u64::from(word.count_ones())).sum()
}

/// The bit of each voxel, as x + 8 y + 64 z.
#[inline]
pub(super) fn each(bits: &Bits, mut see: impl FnMut(usize)) {
    for (z, &word) in bits.iter().enumerate() {
        let mut rest = word;
        while rest != 0 {
            see(z * SIDE * SIDE + rest.trailing_zeros() as usize);
            rest &= rest - 1;
        }
    }
}

impl Block {
    /// The least and the greatest index in the whole map along each axis; of a block that has voxels.
    pub(super) fn extent(&self) -> ([u32; 3], [u32; 3]) {
        let layer = self.all.iter().fold(0, |all, word| all | word);
        let bytes = layer.to_le_bytes();
        let row = bytes.iter().fold(0, |all, byte| all | byte);
        let z = self.all.map(|word| word != 0);
        let y = bytes.map(|byte| byte != 0);
        let x = [0, 1, 2, 3, 4, 5, 6, 7].map(|bit| row >> bit & 1 == 1);
        let first = |used: [bool; SIDE]| used.iter().position(|&is| is).unwrap_or(0);
        let last = |used: [bool; SIDE]| used.iter().rposition(|&is| is).unwrap_or(0);
        (self.index([x, y, z].map(first)), self.index([x, y, z].map(last)))
    }

    fn index(&self, within: [usize; 3]) -> [u32; 3] {
        [0, 1, 2].map(|k| u32::from(self.at[k]) * SIDE as u32 + within[k] as u32)
    }

    /// The index in the whole map of a bit of this block.
    pub(super) fn voxel(&self, bit: usize) -> [u32; 3] {
        self.index([bit % SIDE, bit / SIDE % SIDE, bit / SIDE / SIDE])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_voxels() {
        let mut block = Block {
            at: [2, 0, 1],
            all: [0; SIDE],
            boundary: [0; SIDE],
        };
        for [x, y, z] in [[3, 1, 6], [5, 7, 2], [4, 4, 4]] {
            block.all[z] |= 1 << (x + 8 * y);
        }
        assert_eq!(block.extent(), ([19, 1, 10], [21, 7, 14]));
        let mut seen = Vec::new();
        each(&block.all, |bit| seen.push(block.voxel(bit)));
        assert_eq!(seen, [[21, 7, 10], [20, 4, 12], [19, 1, 14]]);
        assert_eq!(count(&block.all), 3);
    }
}
