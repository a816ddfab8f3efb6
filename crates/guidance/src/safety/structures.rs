//! The structures of a label map, as the blocks that their voxels lie in.

use std::ops::Range;

use geometry::VolumeGrid;

use super::block::{Block, count};
use super::lattice::Lattice;

/// A ball that holds the centres of a block's voxels: what is asked of all blocks lies close together in memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    /// In voxel indices: halves of whole numbers below 2^15, which an f32 holds without error.
    pub(super) centre: [f32; 3],
    /// Rounded up, mm.
    pub(super) radius_mm: f32,
}

impl Ball {
    /// About the voxels from a least to a greatest index along each axis.
    fn about((low, high): ([u32; 3], [u32; 3]), lattice: &Lattice) -> Self {
        Self {
            centre: [0, 1, 2].map(|k| (low[k] + high[k]) as f32 / 2.0),
            radius_mm: lattice.ball_mm([0, 1, 2].map(|k| high[k] - low[k])),
        }
    }
}

/// Blocks along each side of a group.
const GROUP_SIDE: u16 = 4;

/// Blocks that lie together.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Holds the centres of all their voxels.
    pub(super) ball: Ball,
    /// Which blocks of the structure they are.
    pub(super) blocks: Range<usize>,
}

/// One structure: every voxel of one label.
#[derive(Debug, Clone)]
pub struct Structure {
    label: i16,
    voxels: u64,
    boundary: u64,
    low: [u32; 3],
    high: [u32; 3],
    pub(super) groups: Vec<Group>,
    /// One for each block, in the same order.
    pub(super) balls: Vec<Ball>,
    pub(super) blocks: Vec<Block>,
}

impl Structure {
    /// A structure of no block yet.
    pub(super) fn new(label: i16) -> Self {
        Self {
            label,
            voxels: 0,
            boundary: 0,
            low: [u32::MAX; 3],
            high: [0; 3],
            groups: Vec::new(),
            balls: Vec::new(),
            blocks: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, block: Block) {
        let (low, high) = block.extent();
        self.low = [0, 1, 2].map(|k| self.low[k].min(low[k]));
        self.high = [0, 1, 2].map(|k| self.high[k].max(high[k]));
        self.voxels += count(&block.all);
        self.boundary += count(&block.boundary);
        self.blocks.push(block);
    }

    /// Sorts the blocks into groups, once all are there.
    pub(super) fn close(&mut self, lattice: &Lattice) {
        let group_of = |block: &Block| block.at.map(|k| k / GROUP_SIDE);
        self.blocks.sort_unstable_by_key(group_of);
        self.blocks.shrink_to_fit();
        self.balls = self
            .blocks
            .iter()
            .map(|block| Ball::about(block.extent(), lattice))
            .collect();
        for together in self.blocks.chunk_by(|a, b| group_of(a) == group_of(b)) {
            let extents = together.iter().map(Block::extent);
            let whole = extents.reduce(|(low, high), (l, h)| {
                (
                    [0, 1, 2].map(|k| low[k].min(l[k])),
                    [0, 1, 2].map(|k| high[k].max(h[k])),
                )
            });
            let first = self.groups.last().map_or(0, |group| group.blocks.end);
            self.groups.extend(whole.map(|extent| Group {
                ball: Ball::about(extent, lattice),
                blocks: first..first + together.len(),
            }));
        }
    }

    /// Its label, 1 to 32767.
    pub fn label(&self) -> i16 {
        self.label
    }

    /// The number of its voxels.
    pub fn voxels(&self) -> u64 {
        self.voxels
    }

    /// How many of them have one of their six neighbours of another label, or lie at the map's border.
    pub fn boundary_voxels(&self) -> u64 {
        self.boundary
    }

    /// The least and the greatest index of its voxels along each axis.
    pub fn extent(&self) -> ([u32; 3], [u32; 3]) {
        (self.low, self.high)
    }
}

/// The structures of a label map, made to be asked for their distance from a tube. See [the module](super).
#[derive(Debug, Clone)]
pub struct Structures {
    pub(super) grid: VolumeGrid,
    pub(super) lattice: Lattice,
    /// By ascending label.
    pub(super) list: Vec<Structure>,
}

impl Structures {
    /// The grid of the label map.
    pub fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    /// The structures, by ascending label.
    pub fn list(&self) -> &[Structure] {
        &self.list
    }

    /// From a voxel's centre to the farthest corner of its cell, mm: no point of a structure's cells is farther than this from a centre.
    pub fn voxel_half_diagonal_mm(&self) -> f64 {
        self.lattice.half_diagonal_mm
    }

    /// Memory of the blocks, bytes.
    pub fn bytes(&self) -> u64 {
        let blocks: u64 = self.list.iter().map(|structure| structure.blocks.len() as u64).sum();
        blocks * BLOCK_BYTES
    }
}

/// What a block takes, bytes.
pub(super) const BLOCK_BYTES: u64 = (size_of::<Block>() + size_of::<Ball>()) as u64;
