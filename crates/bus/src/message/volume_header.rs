//! What a renderer must know of the volume before it touches a voxel.

use std::fmt;

use geometry::{Affine, GridError, VolumeGrid};
use iceoryx2::prelude::ZeroCopySend;

use crate::volume::{Layout, LayoutError};

/// Travels in front of the voxels, in the same shared-memory sample.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/VolumeHeader/1")]
pub struct VolumeHeader {
    /// `ct_from_voxel`: LPS mm, row by row, the fourth column is the offset. May be sheared.
    pub ct_from_voxel: [[f64; 4]; 3],
    /// BLAKE3 of geometry and voxels: see [`crate::volume::Hasher`].
    pub hash: [u8; 32],
    /// The shared-memory file, so that the pilot can account for its pages.
    pub shm_inode: u64,
    /// Voxels along each axis.
    pub dims: [u32; 3],
    /// Brick sides in voxels, powers of two; 1, 1, 1 is plain rows.
    pub brick: [u32; 3],
    /// The HU of everything outside the volume.
    pub padding_hu: i32,
    /// What every image of this volume must say: [`Marks`].
    pub marks: u32,
}

const _: () = assert!(size_of::<VolumeHeader>() == 168 && align_of::<VolumeHeader>() == 8);

/// Why a volume's header was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeaderError {
    /// The grid is unusable.
    #[error("the volume on the bus: {0}")]
    Grid(#[from] GridError),
    /// The layout is unusable.
    #[error("the volume on the bus: {0}")]
    Layout(#[from] LayoutError),
    /// There are fewer or more voxels than the header says.
    #[error("the volume on the bus holds {found} values, its header asks for {expected}")]
    Length {
        /// Stored voxels, padding of bricks included.
        expected: u64,
        /// Values in the sample.
        found: u64,
    },
}

impl VolumeHeader {
    /// The typed grid: the door from the bus to geometry.
    ///
    /// # Errors
    /// [`HeaderError::Grid`].
    pub fn grid(&self) -> Result<VolumeGrid, HeaderError> {
        Ok(VolumeGrid::checked(
            self.dims.map(i64::from),
            Affine::from_rows(self.ct_from_voxel),
        )?)
    }

    /// How the voxels lie in memory.
    ///
    /// # Errors
    /// [`HeaderError::Layout`].
    pub fn layout(&self) -> Result<Layout, HeaderError> {
        Ok(Layout::new(self.dims, self.brick)?)
    }

    /// What every image of this volume must say.
    pub fn marks(&self) -> Marks {
        Marks(self.marks)
    }

    /// The volume's identity.
    pub fn volume_hash(&self) -> VolumeHash {
        VolumeHash(self.hash)
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
