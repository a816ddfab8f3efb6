//! From the slices of a label map to its structures, in one pass.

use geometry::VolumeGrid;

use super::block::{Block, SIDE};
use super::lattice::Lattice;
use super::refusal::MapError;
use super::structures::{BLOCK_BYTES, Structure, Structures};
use super::window::{OUTSIDE, Window};

/// The most voxels of a slice: ten slices are held while they are read, 320 MiB.
pub const MAX_SLICE_VOXELS: u64 = 1 << 24;
/// The most memory of the blocks of all structures, bytes. Lists that grow may take twice that for a moment.
pub const MAX_BYTES: u64 = 1 << 30;

/// Takes the slices of a label map in their order and keeps what is needed of each.
///
/// It keeps 152 bytes for each label of each block of 8 x 8 x 8 voxels, and ten slices.
pub struct Builder {
    grid: VolumeGrid,
    lattice: Lattice,
    window: Window,
    slices: u32,
    layer: u16,
    /// Where a label's structure is in `list`; [`NONE`] of a label not seen yet.
    place: Vec<u16>,
    list: Vec<Structure>,
    bytes: u64,
    max_bytes: u64,
    /// The labels of one block, and where each label is among them; [`NONE`] between blocks. Taken once.
    found: Vec<(i16, Block)>,
    within: Vec<u16>,
}

const NONE: u16 = u16::MAX;

impl Builder {
    /// For a label map on this grid.
    ///
    /// # Errors
    /// [`MapError::SliceTooLarge`].
    pub fn new(grid: &VolumeGrid) -> Result<Self, MapError> {
        let [x, y, _] = grid.dims();
        let (voxels, allowed) = (u64::from(x) * u64::from(y), MAX_SLICE_VOXELS);
        if voxels > allowed {
            return Err(MapError::SliceTooLarge { voxels, allowed });
        }
        Ok(Self {
            grid: *grid,
            lattice: Lattice::of(grid),
            window: Window::new([x as usize, y as usize]),
            slices: 0,
            layer: 0,
            place: vec![NONE; 1 << 15],
            list: Vec::new(),
            bytes: 0,
            max_bytes: MAX_BYTES,
            found: Vec::new(),
            within: vec![NONE; 1 << 15],
        })
    }

    /// With less memory for the blocks than [`MAX_BYTES`].
    #[must_use]
    pub fn limited_to(mut self, bytes: u64) -> Self {
        self.max_bytes = bytes.min(MAX_BYTES);
        self
    }

    /// Takes the next slice: its labels, x fastest, 0 for background.
    ///
    /// # Errors
    /// [`MapError::SliceSize`], [`MapError::Slices`] of one too many, [`MapError::Negative`], [`MapError::TooLarge`].
    pub fn slice(&mut self, labels: &[i16]) -> Result<(), MapError> {
        let [x, y, slices] = self.grid.dims();
        let (z, width) = (self.slices, x as usize);
        if z == slices {
            let (found, expected) = (u64::from(slices) + 1, slices);
            return Err(MapError::Slices { found, expected });
        }
        let (found, expected) = (labels.len(), width * y as usize);
        if found != expected {
            return Err(MapError::SliceSize { z, found, expected });
        }
        if let Some(at) = labels.iter().position(|&label| label < 0) {
            let (voxel, found) = ([(at % width) as u32, (at / width) as u32, z], labels[at]);
            return Err(MapError::Negative { voxel, found });
        }
        // Of a map that was refused nothing more is taken: its window is full.
        self.bounded()?;
        self.slices += 1;
        if self.window.take(labels) {
            self.layer()?;
            self.window.next_layer();
            self.layer += 1;
        }
        Ok(())
    }

    /// The structures.
    ///
    /// # Errors
    /// [`MapError::Slices`] where some are missing, [`MapError::Empty`], [`MapError::TooLarge`].
    pub fn finish(mut self) -> Result<Structures, MapError> {
        let (found, expected) = (u64::from(self.slices), self.grid.dims()[2]);
        if self.slices != expected {
            return Err(MapError::Slices { found, expected });
        }
        if self.window.close() {
            self.layer()?;
        }
        if self.list.is_empty() {
            let voxels = self.grid.voxels();
            return Err(MapError::Empty { voxels });
        }
        let mut list = self.list;
        list.sort_by_key(Structure::label);
        list.iter_mut().for_each(|structure| structure.close(&self.lattice));
        Ok(Structures {
            grid: self.grid,
            lattice: self.lattice,
            list,
        })
    }

    /// The blocks of the layer that the window holds.
    fn layer(&mut self) -> Result<(), MapError> {
        let [nx, ny, _] = self.grid.dims();
        for y in 0..Window::blocks(ny as usize) {
            for x in 0..Window::blocks(nx as usize) {
                if !self.window.is_background([x, y]) {
                    self.block([x, y]);
                }
            }
            self.bounded()?;
        }
        Ok(())
    }

    /// Refuses what takes too much memory.
    fn bounded(&self) -> Result<(), MapError> {
        if self.bytes <= self.max_bytes {
            return Ok(());
        }
        Err(MapError::TooLarge {
            allowed: self.max_bytes,
            boundary: self.list.iter().map(Structure::boundary_voxels).sum(),
            slices: self.slices,
            of: self.grid.dims()[2],
        })
    }

    /// Sorts the voxels of a block by their labels.
    fn block(&mut self, block: [usize; 2]) {
        let at = [block[0] as u16, block[1] as u16, self.layer];
        for z in 0..SIDE {
            for y in 0..SIDE {
                let (row, boundary) = self.window.look(block, y, z);
                let mut rest = 0xff_u8;
                // Once for each label of the row, which are one or two nearly always.
                while rest != 0 {
                    let label = row[rest.trailing_zeros() as usize];
                    let same = row.iter().rev().fold(0, |bits, &l| bits << 1 | u8::from(l == label));
                    rest &= !same;
                    if label != 0 && label != OUTSIDE {
                        let voxels = self.of_label(label, at);
                        voxels.all[z] |= u64::from(same) << (8 * y);
                        voxels.boundary[z] |= u64::from(same & boundary) << (8 * y);
                    }
                }
            }
        }
        let mut found = std::mem::take(&mut self.found);
        for (label, block) in found.drain(..) {
            self.within[label as usize] = NONE;
            self.structure(label).add(block);
            self.bytes += BLOCK_BYTES;
        }
        self.found = found;
    }

    /// The voxels of a label in the block that is being sorted.
    fn of_label(&mut self, label: i16, at: [u16; 3]) -> &mut Block {
        let place = &mut self.within[label as usize];
        if *place == NONE {
            *place = self.found.len() as u16;
            let (all, boundary) = ([0; SIDE], [0; SIDE]);
            self.found.push((label, Block { at, all, boundary }));
        }
        &mut self.found[usize::from(*place)].1
    }

    fn structure(&mut self, label: i16) -> &mut Structure {
        let place = &mut self.place[label as usize];
        if *place == NONE {
            *place = self.list.len() as u16;
            self.list.push(Structure::new(label));
        }
        &mut self.list[usize::from(*place)]
    }
}

impl Structures {
    /// The structures of a label map that lies in memory: `slice` writes the labels of slice `z`, x fastest, 0 for background. A voxel that
    /// it leaves unwritten is refused.
    ///
    /// # Errors
    /// Each variant of [`MapError`] but those of wrong numbers of slices and voxels.
    pub fn build(grid: &VolumeGrid, mut slice: impl FnMut(u32, &mut [i16])) -> Result<Self, MapError> {
        let [x, y, slices] = grid.dims();
        let mut builder = Builder::new(grid)?;
        let mut labels = vec![0; x as usize * y as usize];
        for z in 0..slices {
            labels.fill(i16::MIN);
            slice(z, &mut labels);
            builder.slice(&labels)?;
        }
        builder.finish()
    }
}
