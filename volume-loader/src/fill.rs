//! From a source's slices to voxels in their places.

use bus::message::VolumeHash;
use bus::volume::{Hasher, Layout};

use crate::error::LoadError;
use crate::source::{Conversion, VoxelSource};

/// What is known after the last slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Filled {
    /// The volume's identity.
    pub hash: VolumeHash,
    /// How many voxels were changed on the way.
    pub conversion: Conversion,
}

/// Reads every slice of `source` into `stored` and takes the hash on the way. One slice is held beside `stored`.
///
/// `progress` is called with the number of slices read and says whether to go on.
///
/// # Errors
/// The source's, or [`LoadError::Stopped`]; what is in `stored` then is not a volume.
pub fn fill(
    source: &mut dyn VoxelSource,
    layout: &Layout,
    stored: &mut [i16],
    mut progress: impl FnMut(u32) -> bool,
) -> Result<Filled, LoadError> {
    let grid = *source.grid();
    let [columns, rows, slices] = grid.dims();
    let mut slice = vec![0; columns as usize * rows as usize];
    let mut hasher = Hasher::new(&grid, source.padding_hu());
    for k in 0..slices {
        if !progress(k) {
            return Err(LoadError::Stopped);
        }
        source.read_slice(k, &mut slice)?;
        layout.scatter(k, &slice, stored);
        hasher.update(&slice);
    }
    let conversion = source.finish()?;
    Ok(Filled {
        hash: hasher.finish(),
        conversion,
    })
}
