//! A part of an examination, and several voxels made one: what a scene does not need is never in memory.
//!
//! The part is cut along the examination's own voxels, so that no value changes. Blocks of voxels become their mean,
//! padding left out; what that costs is measured while reading and told in [`Part::remarks`].

mod blocks;
mod bounds;

#[cfg(test)]
mod tests;

use std::sync::Mutex;
use std::sync::PoisonError;

use bus::message::Marks;
use geometry::{Affine, Ct, GridError, Point, VolumeGrid, Voxel};
use scene::{Region, VolumeSpec};

use crate::source::{Conversion, Facts, ReadError, Scratch, SliceReader, Turn, VoxelSource, Whose};
pub use blocks::Sums;
use blocks::{Blocks, Loss};
pub use bounds::RegionError;

/// A part of `inner`, its voxels joined in blocks.
pub struct Part {
    inner: Box<dyn VoxelSource>,
    first: [u32; 3],
    block: [u32; 3],
    grid: VolumeGrid,
    whole: bool,
    turn: Turn,
    /// The next slice of `inner`.
    next: u32,
    scratch: Scratch,
    loss: Mutex<Loss>,
}

/// `source` as `spec` wants it: itself, where that is all of it.
///
/// # Errors
/// [`RegionError`].
pub fn part(source: Box<dyn VoxelSource>, spec: &VolumeSpec) -> Result<Box<dyn VoxelSource>, RegionError> {
    if spec.region.is_none() && spec.downsample == [1; 3] {
        return Ok(source);
    }
    Ok(Box::new(Part::new(source, spec.region.as_ref(), spec.downsample)?))
}

impl Part {
    /// The part of `inner` in `region`, whole blocks of `block` voxels from its first corner on.
    ///
    /// # Errors
    /// [`RegionError`].
    pub fn new(inner: Box<dyn VoxelSource>, region: Option<&Region>, block: [u32; 3]) -> Result<Self, RegionError> {
        let all = [[0; 3], inner.grid().dims()];
        let [first, end] = match region {
            Some(region) => bounds::of(region, inner.grid())?,
            None => all,
        };
        let size: [u32; 3] = std::array::from_fn(|a| end[a] - first[a]);
        let dims: [u32; 3] = std::array::from_fn(|a| size[a] / block[a]);
        if let Some(axis) = (0..3).find(|&a| dims[a] == 0) {
            return Err(RegionError::Block {
                axis,
                voxels: size[axis],
                block: block[axis],
            });
        }
        Ok(Self {
            grid: coarse(inner.grid(), first, block, dims)?,
            whole: [first, end] == all,
            inner,
            first,
            block,
            turn: Turn::default(),
            next: 0,
            scratch: Scratch::default(),
            loss: Mutex::default(),
        })
    }

    fn blocks(&self) -> Blocks {
        Blocks {
            first: self.first,
            block: self.block,
            columns: self.inner.grid().dims()[0] as usize,
            dims: self.grid.dims(),
            padding_hu: self.inner.padding_hu(),
        }
    }

    fn inner_slice_voxels(&self) -> usize {
        let [columns, rows, _] = self.inner.grid().dims();
        columns as usize * rows as usize
    }

    /// Which slices of `inner` slice `k` is made of.
    fn slices_of(&self, k: u32) -> std::ops::Range<u32> {
        let first = self.first[2] + k * self.block[2];
        first..first + self.block[2]
    }

    fn joined(&self) -> bool {
        self.block != [1; 3]
    }

    /// Keeps what the joining of one slice's blocks cost.
    fn note(&self, loss: Loss) {
        self.loss.lock().unwrap_or_else(PoisonError::into_inner).add(loss);
    }
}

/// The grid of blocks: a block's place is the mean of its voxels' places.
fn coarse(grid: &VolumeGrid, first: [u32; 3], block: [u32; 3], dims: [u32; 3]) -> Result<VolumeGrid, GridError> {
    let ct_from_voxel = grid.ct_from_voxel();
    let middle: [f64; 3] = std::array::from_fn(|a| f64::from(first[a]) + 0.5 * f64::from(block[a] - 1));
    let origin: Point<Ct> = ct_from_voxel * Point::<Voxel>::new(middle[0], middle[1], middle[2]);
    let steps = std::array::from_fn(|a| ct_from_voxel.step(a) * f64::from(block[a]));
    VolumeGrid::checked(dims.map(i64::from), Affine::from_steps(origin, steps))
}

impl VoxelSource for Part {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn padding_hu(&self) -> i16 {
        self.inner.padding_hu()
    }

    fn describe(&self) -> String {
        let mut text = self.inner.describe();
        if !self.whole {
            let [first, dims, block] = [self.first, self.grid.dims(), self.block];
            let last: [u32; 3] = std::array::from_fn(|a| first[a] + dims[a] * block[a] - 1);
            text.push_str(&format!("; only voxels {first:?} to {last:?}"));
        }
        if self.joined() {
            let ([nx, ny, nz], [bx, by, bz]) = (self.grid.dims(), self.block);
            text.push_str(&format!("; {bx} x {by} x {bz} voxels made one: {nx} x {ny} x {nz}"));
        }
        text
    }

    fn marks(&self) -> Marks {
        let mut marks = self.inner.marks();
        if !self.whole {
            marks = marks.and(Marks::PART);
        }
        if self.joined() {
            marks = marks.and(Marks::DOWNSAMPLED);
        }
        marks
    }

    fn facts(&self) -> Facts {
        self.inner.facts()
    }

    fn whose(&self) -> Result<Whose, ReadError> {
        self.inner.whose()
    }

    fn remarks(&self) -> Vec<String> {
        let mut remarks = self.inner.remarks();
        if self.joined() {
            remarks.push(self.loss.lock().unwrap_or_else(PoisonError::into_inner).to_string());
        }
        remarks
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.grid, k, out)?;
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.slice.resize(self.inner_slice_voxels(), 0);
        let mut joining = self.blocks().begin(&mut scratch.sums);
        let wanted = self.slices_of(k);
        while self.next < wanted.end {
            self.inner.read_slice(self.next, &mut scratch.slice)?;
            if wanted.contains(&self.next) {
                joining.add(&scratch.slice, out);
            }
            self.next += 1;
        }
        let loss = joining.finish(out);
        self.note(loss);
        self.scratch = scratch;
        Ok(())
    }

    /// A stream is whole only once all of it was read, what lies behind the part too.
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.grid)?;
        self.scratch.slice.resize(self.inner_slice_voxels(), 0);
        for k in self.next..self.inner.grid().dims()[2] {
            self.inner.read_slice(k, &mut self.scratch.slice)?;
        }
        self.inner.finish()
    }

    fn slices(&self) -> Option<&dyn SliceReader> {
        self.inner.slices().map(|_| self as &dyn SliceReader)
    }
}

impl SliceReader for Part {
    fn read(&self, k: u32, out: &mut [i16], scratch: &mut Scratch) -> Result<Conversion, ReadError> {
        // Offered by `slices` only where there are some.
        let Some(inner) = self.inner.slices() else {
            return Ok(Conversion::default());
        };
        let (mut slice, mut sums) = (std::mem::take(&mut scratch.slice), std::mem::take(&mut scratch.sums));
        slice.resize(self.inner_slice_voxels(), 0);
        let mut joining = self.blocks().begin(&mut sums);
        let mut conversion = Conversion::default();
        for k in self.slices_of(k) {
            conversion += inner.read(k, &mut slice, scratch)?;
            joining.add(&slice, out);
        }
        let loss = joining.finish(out);
        self.note(loss);
        (scratch.slice, scratch.sums) = (slice, sums);
        Ok(conversion)
    }
}
