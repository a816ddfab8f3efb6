//! Blocks of voxels to their mean, padding left out, and what that costs.

use std::fmt;

/// How slices are cut and joined.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blocks {
    pub first: [u32; 3],
    pub block: [u32; 3],
    /// Columns of a slice that comes in.
    pub columns: usize,
    /// Of what goes out.
    pub dims: [u32; 3],
    pub padding_hu: i16,
}

/// The voxels of one block so far.
#[derive(Debug, Default, Clone, Copy)]
pub struct Sums {
    count: u32,
    sum: i64,
    squares: u64,
}

#[cfg(test)]
impl Sums {
    pub(super) fn of(voxels: &[i64]) -> Self {
        Self {
            count: voxels.len() as u32,
            sum: voxels.iter().sum(),
            squares: voxels.iter().map(|v| (v * v) as u64).sum(),
        }
    }
}

/// One slice of blocks being joined.
pub(super) struct Joining<'a> {
    blocks: Blocks,
    sums: &'a mut Vec<Sums>,
}

impl Blocks {
    pub(super) fn begin(self, sums: &mut Vec<Sums>) -> Joining<'_> {
        sums.clear();
        if self.block != [1; 3] {
            sums.resize(self.dims[0] as usize * self.dims[1] as usize, Sums::default());
        }
        Joining { blocks: self, sums }
    }

    /// The rows of a slice that lie in the part, each cut to it; and which row of blocks each belongs to.
    fn rows<'a>(&self, slice: &'a [i16]) -> impl Iterator<Item = (usize, &'a [i16])> {
        let [bx, by] = [self.block[0] as usize, self.block[1] as usize];
        let (from, length) = (self.first[0] as usize, self.dims[0] as usize * bx);
        let rows = slice.chunks_exact(self.columns).skip(self.first[1] as usize);
        let rows = rows.take(self.dims[1] as usize * by).enumerate();
        rows.map(move |(y, row)| (y / by, &row[from..from + length]))
    }
}

impl Joining<'_> {
    /// Adds a slice of the block; where a block is one voxel this is all there is to do.
    pub(super) fn add(&mut self, slice: &[i16], out: &mut [i16]) {
        let (width, bx) = (self.blocks.dims[0] as usize, self.blocks.block[0] as usize);
        if self.sums.is_empty() {
            for ((_, row), out) in self.blocks.rows(slice).zip(out.chunks_exact_mut(width)) {
                out.copy_from_slice(row);
            }
            return;
        }
        for (by, row) in self.blocks.rows(slice) {
            for (sums, voxels) in self.sums[by * width..].iter_mut().zip(row.chunks_exact(bx)) {
                for &hu in voxels.iter().filter(|&&hu| hu != self.blocks.padding_hu) {
                    let hu = i64::from(hu);
                    sums.count += 1;
                    sums.sum += hu;
                    sums.squares += (hu * hu) as u64;
                }
            }
        }
    }

    /// The means; what the joining cost.
    pub(super) fn finish(self, out: &mut [i16]) -> Loss {
        let mut loss = Loss::default();
        for (sums, out) in self.sums.iter().zip(out) {
            *out = loss.mean(*sums).unwrap_or(self.blocks.padding_hu);
        }
        loss
    }
}

/// How far voxels were from the value that their block was given.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Loss {
    voxels: u64,
    squares: f64,
    worst_rms: f64,
}

impl Loss {
    /// The mean of a block's voxels; `None` where all are padding.
    pub(super) fn mean(&mut self, sums: Sums) -> Option<i16> {
        if sums.count == 0 {
            return None;
        }
        let n = f64::from(sums.count);
        let mean = (sums.sum as f64 / n).round();
        // Exact: whole numbers below 2^53 (4096 voxels of 2^30).
        let squares = sums.squares as f64 - 2.0 * mean * sums.sum as f64 + n * mean * mean;
        self.voxels += u64::from(sums.count);
        self.squares += squares;
        self.worst_rms = self.worst_rms.max((squares / n).sqrt());
        // Within the voxels' own range.
        Some(mean as i16)
    }

    pub(super) fn add(&mut self, other: Self) {
        self.voxels += other.voxels;
        self.squares += other.squares;
        self.worst_rms = self.worst_rms.max(other.worst_rms);
    }

    /// Root mean square distance of the voxels from their block's value, HU.
    pub(super) fn rms_hu(&self) -> f64 {
        (self.squares / (self.voxels.max(1)) as f64).sqrt()
    }

    /// The largest such of one block, HU.
    pub(super) fn worst_rms_hu(&self) -> f64 {
        self.worst_rms
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "voxels made one differed from their mean by {:.1} HU (rms), by {:.0} HU in the worst block",
            self.rms_hu(),
            self.worst_rms_hu()
        )
    }
}
