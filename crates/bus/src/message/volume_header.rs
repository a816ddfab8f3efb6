//! What a renderer must know of the volume before it touches a voxel.

use geometry::{Affine, GridError, VolumeGrid};
use iceoryx2::prelude::ZeroCopySend;

use crate::volume::{Layout, LayoutError, Marks, VolumeHash};

/// Travels in front of the voxels, in the same shared-memory sample.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
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
    /// The header of a volume whose shared-memory file is not known yet.
    pub fn new(grid: &VolumeGrid, layout: &Layout, padding_hu: i16, hash: VolumeHash, marks: Marks) -> Self {
        Self {
            ct_from_voxel: grid.ct_from_voxel().rows(),
            hash: hash.0,
            shm_inode: 0,
            dims: grid.dims(),
            brick: layout.brick(),
            padding_hu: i32::from(padding_hu),
            marks: marks.0,
        }
    }

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
