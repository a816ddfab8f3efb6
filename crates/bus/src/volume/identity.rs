//! What a volume is: its identity, and what was done to its voxels.

use std::fmt;

use geometry::VolumeGrid;

/// Identity of a volume: BLAKE3 over dimensions, `ct_from_voxel`, padding, and the BLAKE3 of each slice, whose voxels go
/// row by row, little-endian. Slices are hashed apart so that threads can share the work.
///
/// Independent of the layout in memory, so that the same examination has the same name everywhere.
#[derive(Debug, Clone)]
pub struct Hasher {
    hasher: blake3::Hasher,
}

/// BLAKE3 of one slice's voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SliceHash([u8; 32]);

impl SliceHash {
    /// Of a slice, row by row.
    pub fn of(slice: &[i16]) -> Self {
        if cfg!(target_endian = "little") {
            return Self(*blake3::hash(bytemuck::cast_slice(slice)).as_bytes());
        }
        let mut hasher = blake3::Hasher::new();
        for part in slice.chunks(512) {
            let mut bytes = [0; 1024];
            for (place, value) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(part) {
                *place = value.to_le_bytes();
            }
            hasher.update(&bytes[..2 * part.len()]);
        }
        Self(*hasher.finalize().as_bytes())
    }
}

impl Hasher {
    /// Starts with the geometry.
    pub fn new(grid: &VolumeGrid, padding_hu: i16) -> Self {
        let mut hasher = blake3::Hasher::new_derive_key("trocar volume 2");
        for dim in grid.dims() {
            hasher.update(&dim.to_le_bytes());
        }
        for number in grid.ct_from_voxel().rows().iter().flatten() {
            hasher.update(&number.to_bits().to_le_bytes());
        }
        hasher.update(&padding_hu.to_le_bytes());
        Self { hasher }
    }

    /// Adds the next slice.
    pub fn update(&mut self, slice: SliceHash) {
        self.hasher.update(&slice.0);
    }

    /// The identity.
    pub fn finish(&self) -> VolumeHash {
        VolumeHash(*self.hasher.finalize().as_bytes())
    }
}

/// What every image of a volume must say, because the voxels are not the scanner's own, or not all of them.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Marks(pub(crate) u32);

impl Marks {
    /// The scanner's voxels, all of them.
    pub const NONE: Self = Self(0);
    /// Slices at uneven places were interpolated to even ones.
    pub const REGRIDDED: Self = Self(1);
    /// Several voxels were made one.
    pub const DOWNSAMPLED: Self = Self(2);
    /// Only a part of the examination was loaded; black outside it is not air.
    pub const PART: Self = Self(4);
    const WORDS: [(Self, &'static str); 3] = [
        (Self::REGRIDDED, "REGRIDDED"),
        (Self::DOWNSAMPLED, "DOWNSAMPLED"),
        (Self::PART, "PART OF CT"),
    ];

    /// These and those.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `other` are among these.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// In capitals, for the legend of an image; empty where there is nothing to say. A mark of a later version, unknown
    /// here, is said too.
    pub fn words(self) -> String {
        let known = Self::WORDS.iter().filter(|(mark, _)| self.has(*mark));
        let mut words: Vec<&str> = known.map(|(_, word)| *word).collect();
        if self.0 > 7 {
            words.push("ALTERED");
        }
        words.join(", ")
    }
}

/// The identity of a volume: 256 bits of BLAKE3 over its geometry and voxels.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct VolumeHash(pub [u8; 32]);

impl fmt::Display for VolumeHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for VolumeHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VolumeHash({self})")
    }
}
