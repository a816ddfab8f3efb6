//! Stored voxels in this process's own memory, beginning where a cache line does.

use std::ops::{Deref, DerefMut};

/// Where voxels begin, bytes: a brick of 4 x 4 x 4 of them is then two whole cache lines, and not parts of three.
pub const ALIGNMENT: usize = 128;

/// As many values as lie between two such places.
const STEP: usize = ALIGNMENT / size_of::<i16>();

/// Stored voxels, HU, that begin at a multiple of [`ALIGNMENT`].
#[derive(Debug)]
pub struct Voxels {
    /// With room before the first one.
    values: Vec<i16>,
    first: usize,
}

impl Voxels {
    /// `count` voxels of 0 HU. Memory is taken page by page as they are written.
    pub fn zeroed(count: usize) -> Self {
        let values = vec![0; count + STEP - 1];
        // 0 to STEP - 1: a Vec of i16 begins at an even address.
        let first = values.as_ptr().addr().wrapping_neg() % ALIGNMENT / size_of::<i16>();
        let mut voxels = Self { values, first };
        voxels.values.truncate(first + count);
        voxels
    }
}

impl Deref for Voxels {
    type Target = [i16];

    fn deref(&self) -> &[i16] {
        &self.values[self.first..]
    }
}

impl DerefMut for Voxels {
    fn deref_mut(&mut self) -> &mut [i16] {
        &mut self.values[self.first..]
    }
}

impl Clone for Voxels {
    fn clone(&self) -> Self {
        let mut other = Self::zeroed(self.len());
        other.copy_from_slice(self);
        other
    }
}

impl From<&[i16]> for Voxels {
    fn from(values: &[i16]) -> Self {
        let mut voxels = Self::zeroed(values.len());
        voxels.copy_from_slice(values);
        voxels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn begin_at_a_line_and_keep_their_values() {
        for count in [0, 1, 63, 64, 65, 1000] {
            let values: Vec<i16> = (0..count).collect();
            let voxels = Voxels::from(&values[..]);
            let copies = [voxels.clone(), voxels];
            for copy in &copies {
                assert_eq!(copy.as_ptr().addr() % ALIGNMENT, 0);
                assert_eq!(**copy, values);
            }
        }
    }
}
