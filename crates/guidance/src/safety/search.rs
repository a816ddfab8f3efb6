//! The nearest voxel of one structure.

use super::block::{Bits, Block};
use super::placed::{Line, Placed};
use super::structures::{Ball, Structure};

/// The nearest voxel that was found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) signed_mm: f64,
    pub(super) depth_mm: f64,
    pub(super) voxel: [u32; 3],
}

/// A block that may hold the nearest voxel: the least distance that its ball allows, and which it is.
type Candidate = (f64, usize);

/// A search for the nearest voxels of structures. The distance from a solid changes by no more than one moves, so that no point of
/// a ball is nearer than its centre by more than its radius.
pub(super) struct Search<'a> {
    pub(super) tube: &'a Placed,
    /// See [`super::lattice::Lattice::reach_mm`].
    pub(super) reach_mm: f64,
    candidates: Vec<Candidate>,
}

impl<'a> Search<'a> {
    pub(super) fn new(tube: &'a Placed, reach_mm: f64) -> Self {
        Self {
            tube,
            reach_mm,
            candidates: Vec::new(),
        }
    }

    /// The signed distance of a ball's centre, and the ball's radius.
    fn middle(&self, ball: &Ball) -> (f64, f64) {
        let centre = self.tube.about(ball.centre.map(f64::from));
        (self.tube.signed(centre), f64::from(ball.radius_mm))
    }

    /// The voxel of least signed distance, where that is less than `limit`.
    pub(super) fn nearest(&mut self, structure: &Structure, limit: f64) -> Option<Found> {
        self.gather(structure, limit);
        let mut best: Option<Found> = None;
        for &(least, k) in &self.candidates {
            let so_far = best.map_or(limit, |found| found.signed_mm);
            if least >= so_far {
                break;
            }
            let block = &structure.blocks[k];
            if let Some(found) = self.within(block, self.seen(block, least), so_far) {
                best = Some(found);
            }
        }
        best
    }

    /// The blocks that may hold it, most promising first.
    fn gather(&mut self, structure: &Structure, limit: f64) {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.clear();
        let mut most = limit;
        for group in &structure.groups {
            let (middle, radius) = self.middle(&group.ball);
            if middle - radius > most {
                continue;
            }
            for k in group.blocks.clone() {
                let (middle, radius) = self.middle(&structure.balls[k]);
                if middle - radius <= most {
                    candidates.push((middle - radius, k));
                    // Each block has a voxel, which is no farther than its ball reaches.
                    most = most.min(middle + radius);
                }
            }
        }
        candidates.retain(|&(least, _)| least <= most);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        self.candidates = candidates;
    }

    /// The voxels of a block that may be the nearest of their label: beyond the reach those of its boundary.
    fn seen<'b>(&self, block: &'b Block, least_mm: f64) -> &'b Bits {
        if least_mm <= self.reach_mm {
            &block.all
        } else {
            &block.boundary
        }
    }

    /// The voxel of a block whose signed distance is least, where that is less than `limit`.
    fn within(&self, block: &Block, bits: &Bits, limit: f64) -> Option<Found> {
        let mut best = limit;
        let mut found = None;
        self.tube.each(block, bits, |bit, about| {
            let signed = self.tube.signed(about);
            if signed < best {
                best = signed;
                found = Some((bit, about[2]));
            }
        });
        found.map(|(bit, depth_mm)| Found {
            signed_mm: best,
            depth_mm,
            voxel: block.voxel(bit),
        })
    }

    /// Whether the tube's axis runs through the cell of a voxel of `structure`. `half_diagonal` is that of a cell, mm.
    pub(super) fn is_pierced(&self, structure: &Structure, line: &Line, half_diagonal: f64) -> bool {
        structure.balls.iter().zip(&structure.blocks).any(|(ball, block)| {
            let (middle, radius) = self.middle(ball);
            let mut is_pierced = false;
            // A cell that the axis meets has its centre no farther from the axis than its half diagonal.
            if middle - radius <= half_diagonal {
                self.tube.each(block, &block.all, |bit, about| {
                    is_pierced |= self.tube.signed(about) <= half_diagonal && line.meets(block.voxel(bit));
                });
            }
            is_pierced
        })
    }
}
