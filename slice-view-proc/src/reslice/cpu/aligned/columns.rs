//! Along a row: which voxels of a line each column takes, and with which weights.

use std::ops::Range;

use super::super::vector::Vector;
use super::super::walk::{LANES, Walk};
use super::{Axes, QUAD, Separable};

/// The columns of a row, in blocks of [`LANES`]; the last block repeats its last column.
#[derive(Debug, Clone, Default)]
pub(in crate::reslice::cpu) struct Columns {
    /// What these are for.
    inside: Range<usize>,
    /// The voxels that they take: whole quads.
    reach: Range<i32>,
    /// Of each block: the first voxel that it takes, counted from that of `reach`.
    pub(in crate::reslice::cpu) blocks: Vec<u32>,
    /// Of each column: how far its first voxel is behind that of its block.
    pub(in crate::reslice::cpu) behind: Vec<u32>,
    /// The first weight of every column, then the second of every column, and so on.
    pub(in crate::reslice::cpu) weights: Vec<f32>,
    /// No column is further behind than a block is long.
    close: bool,
}

impl Columns {
    /// Forgets the last image.
    pub(super) fn clear(&mut self) {
        self.inside = 0..0;
    }

    /// Whether they are those inside the volume on `walk`.
    pub(super) fn are_of(&self, walk: &Walk) -> bool {
        self.inside == walk.inside
    }

    /// The voxels that they take.
    pub(super) fn reach(&self) -> Range<i32> {
        self.reach.clone()
    }

    /// How many values a line must have to be read by [`Columns::draw`]; those beyond the reach do not matter.
    pub(super) fn room<const N: usize>(&self) -> usize {
        self.reach.len() + LANES + N
    }

    /// Takes the columns of `walk`.
    #[inline(always)]
    pub(super) fn set<const N: usize, K: Separable<N>>(&mut self, kernel: &K, axes: Axes, walk: &Walk) {
        let (quad, last) = (QUAD as i32, walk.inside.end - 1);
        let count = walk.inside.len().next_multiple_of(LANES);
        // The last column again, up to whole blocks of eight.
        let columns = || (walk.inside.start..).map(|column| column.min(last)).take(count);
        let firsts = || columns().map(|column| K::first(&walk.at(column), axes.right));
        let (low, high) = firsts().fold((i32::MAX, i32::MIN), |(low, high), i| (low.min(i), high.max(i)));
        // Quads begin at multiples of four, as rows of bricks do.
        let start = low.div_euclid(quad) * quad;
        self.inside = walk.inside.clone();
        self.reach = start..start + (high + N as i32 - start + quad - 1) / quad * quad;
        self.behind.clear();
        self.behind.extend(firsts().map(|i| (i - start) as u32));
        self.blocks.clear();
        for block in self.behind.as_chunks_mut::<LANES>().0 {
            let least = block.iter().fold(u32::MAX, |least, &i| least.min(i));
            block.iter_mut().for_each(|i| *i -= least);
            self.blocks.push(least);
        }
        // Eight columns whose first voxels lie within eight are read at once and picked from.
        self.close = self.behind.iter().all(|&i| i < LANES as u32);
        self.weights.clear();
        self.weights.resize(N * count, 0.0);
        for (c, column) in columns().enumerate() {
            let weights = kernel.weights(walk.at(column).part[axes.right]);
            for (k, weight) in weights.into_iter().enumerate() {
                self.weights[k * count + c] = weight;
            }
        }
    }

    /// Weighs the values of a line, which begins at the reach's first voxel, into the columns.
    #[inline(always)]
    pub(super) fn draw<const N: usize>(&self, vector: Option<Vector>, values: &[f32], line: &mut [f32]) {
        match vector {
            Some(vector) if self.close => vector.along::<N>(self, values, line),
            _ => self.one_by_one::<N>(values, line),
        }
    }

    #[inline(always)]
    fn one_by_one<const N: usize>(&self, values: &[f32], line: &mut [f32]) {
        let count = self.behind.len();
        for (b, (block, pixels)) in self.blocks.iter().zip(line.chunks_mut(LANES)).enumerate() {
            for (i, pixel) in pixels.iter_mut().enumerate() {
                let column = b * LANES + i;
                // One slice, so that bounds are checked once for all taps.
                let taken = &values[(block + self.behind[column]) as usize..][..N];
                let mut sum = 0.0;
                for (k, value) in taken.iter().enumerate() {
                    sum += self.weights[k * count + column] * value;
                }
                *pixel = sum;
            }
        }
    }
}
