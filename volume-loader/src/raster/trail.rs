//! Bytes behind the last voxel. No format has any: teem warns of them, ITK and nibabel pass them over. Padding to some block is told of; a
//! slice of them is refused, as the header then has one slice too few, or other dimensions than the voxels.

use std::path::Path;

/// Padding to some block is no longer than this, bytes.
const MAX_TRAIL: u64 = 1 << 16;

/// The most bytes that may follow the last voxel, where a slice has `slice_bytes`.
pub(crate) fn most(slice_bytes: u64) -> u64 {
    MAX_TRAIL.min(slice_bytes.saturating_sub(1))
}

/// The doubt about `behind` bytes that follow the last voxel from byte `end` on, in the unpacked data.
pub(crate) fn doubt(path: &Path, end: u64, behind: u64) -> Option<String> {
    (behind > 0).then(|| {
        format!(
            "{}: the voxels end at byte {end} and {behind} more follow, which are not read: the header's dimensions may be wrong",
            path.display()
        )
    })
}

/// The same of a compressed file, which has `packed_behind` more bytes behind the compressed ones.
pub(crate) fn packed(path: &Path, end: u64, behind: u64, packed_behind: u64) -> Vec<String> {
    let left = (packed_behind > 0).then(|| {
        format!(
            "{}: {packed_behind} bytes follow the compressed voxels and are not read: voxels may be missing",
            path.display()
        )
    });
    doubt(path, end, behind).into_iter().chain(left).collect()
}
