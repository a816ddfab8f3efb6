//! Positions along a row, in fixed point: whole voxel and 24-bit fraction, which is exactly what an f32 weight holds.
//!
//! A row is cut into blocks of eight columns that begin at multiples of eight. Each block's first position comes from f64;
//! the seven others are offsets that are the same for the whole row. So a position is off by at most 2^-25 of a voxel
//! twice, however long the row, and depends on nothing but plane and column: not on tiles, threads or the instruction
//! set. f32 positions would be off by up to 3e-5 of a voxel, which is 0.1 HU at the edge of a bone.

use std::ops::Range;

use super::super::Samples;

/// Columns of a block.
pub(super) const LANES: usize = 8;
/// Bits of a fraction.
pub(super) const BITS: u32 = 24;
const ONE: f64 = (1 << BITS) as f64;
const MASK: i32 = (1 << BITS) - 1;
/// Longest step whose seventh multiple fits in 31 bits with its fraction, voxels.
// Seven of them are 112 voxels; with a fraction below 1 that is less than 2^7 voxels of 2^24 parts.
const LONGEST_STEP: f64 = 16.0;

/// A row of points through the volume.
#[derive(Debug, Clone)]
pub(super) struct Walk {
    start: [f64; 3],
    step: [f64; 3],
    /// Offsets of a block's columns from its first, 24-bit fractions; `None` where they are too long.
    pub(super) lanes: Option<[[i32; LANES]; 3]>,
    /// The columns whose points are inside the volume.
    pub(super) inside: Range<usize>,
}

/// A point: voxel and fraction on each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Spot {
    pub(super) whole: [i32; 3],
    pub(super) part: [i32; 3],
}

impl Spot {
    /// The point of a block's column, from the block's first.
    #[inline(always)]
    fn moved(mut self, lanes: &[[i32; LANES]; 3], lane: usize) -> Self {
        for (a, offsets) in lanes.iter().enumerate() {
            let moved = self.part[a] + offsets[lane];
            self.whole[a] += moved >> BITS;
            self.part[a] = moved & MASK;
        }
        self
    }
}

impl Walk {
    /// Row `y` of layer `d` of `samples`, `width` points long, in a volume of `dims` voxels.
    pub(super) fn new(
        samples: &Samples,
        lanes: Option<[[i32; LANES]; 3]>,
        [y, d]: [f64; 2],
        width: usize,
        dims: [u32; 3],
    ) -> Self {
        let start = samples.at(0.0, y, d);
        Self {
            inside: inside(samples, [y, d], width, dims),
            start,
            step: samples.right,
            lanes,
        }
    }

    /// A single point, at a continuous index; none outside the volume.
    #[inline(always)]
    pub(super) fn one(index: [f64; 3], dims: [u32; 3]) -> Option<Self> {
        holds(index, dims).then_some(Self {
            start: index,
            step: [0.0; 3],
            lanes: None,
            inside: 0..1,
        })
    }

    /// The first point of block `b`.
    #[inline(always)]
    pub(super) fn block(&self, b: usize) -> Spot {
        self.spot((b * LANES) as f64)
    }

    #[inline(always)]
    fn spot(&self, column: f64) -> Spot {
        // Added to 1.5 x 2^52, a number below 2^51 leaves its nearest whole number in the lower bits: one sum instead of
        // a conversion with its checks. Inside, indices have 24 bits of fraction and at most 24 before.
        const ROUNDER: f64 = 6_755_399_441_055_744.0;
        let (mut whole, mut part) = ([0; 3], [0; 3]);
        for a in 0..3 {
            let index = self.start[a] + self.step[a] * column;
            let fixed = (index * ONE + ROUNDER).to_bits().wrapping_sub(ROUNDER.to_bits()) as i64;
            // An arithmetic shift rounds down: the fraction is never negative, before voxel 0 either.
            whole[a] = (fixed >> BITS) as i32;
            part[a] = fixed as i32 & MASK;
        }
        Spot { whole, part }
    }

    /// The point of `column`.
    #[inline(always)]
    pub(super) fn at(&self, column: usize) -> Spot {
        let Some(lanes) = &self.lanes else {
            return self.spot(column as f64);
        };
        self.block(column / LANES).moved(lanes, column % LANES)
    }

    /// Calls `draw` with the point of each of `columns`.
    #[inline(always)]
    pub(super) fn each(&self, columns: Range<usize>, line: &mut [f32], mut draw: impl FnMut(Spot) -> f32) {
        let Some(lanes) = &self.lanes else {
            for (column, value) in columns.zip(line) {
                *value = draw(self.spot(column as f64));
            }
            return;
        };
        let mut block = self.block(columns.start / LANES);
        for (column, value) in columns.zip(line) {
            let lane = column % LANES;
            if lane == 0 {
                block = self.block(column / LANES);
            }
            *value = draw(block.moved(lanes, lane));
        }
    }

    /// The columns whose points lie at least `low` behind voxel 0 and `high` before voxel n - 1 on every axis, less one
    /// step at each end: there the taps exist whatever the rounding.
    pub(super) fn interior(&self, dims: [u32; 3], [low, high]: [f64; 2]) -> Range<usize> {
        // Where a row does not move along an axis, only rounding does.
        const ROUNDING: f64 = 1e-6;
        let (mut from, mut to) = (self.inside.start as f64, self.inside.end as f64);
        for (a, n) in dims.into_iter().enumerate() {
            let (first, last) = (low, f64::from(n) - 1.0 - high);
            let (start, step) = (self.start[a], self.step[a]);
            if step.abs() < 1e-9 {
                // Even at the end of the longest row this is within the rounding allowed for.
                // Negated as a whole, so that a NaN has no interior.
                if !(start >= first + 10.0 * ROUNDING && start <= last - 10.0 * ROUNDING) {
                    return 0..0;
                }
                continue;
            }
            let (near, far) = ((first - start) / step, (last - start) / step);
            from = from.max(near.min(far) + 1.0 + ROUNDING / step.abs());
            to = to.min(near.max(far) - ROUNDING / step.abs());
        }
        let (from, to) = (from.ceil(), to.floor());
        if from < to { from as usize..to as usize } else { 0..0 }
    }
}

/// The offsets of a block's columns, or `None` where the step is too long for them.
pub(super) fn lanes(step: [f64; 3]) -> Option<[[i32; LANES]; 3]> {
    let short = step.iter().all(|s| s.abs() <= LONGEST_STEP);
    short.then(|| step.map(|s| std::array::from_fn(|k| (s * k as f64 * ONE).round() as i32)))
}

/// Whether a point is inside the volume, by the border rule in f64.
#[inline(always)]
pub(in crate::reslice) fn holds(index: [f64; 3], dims: [u32; 3]) -> bool {
    (0..3).all(|a| index[a] >= -0.5 && index[a] <= f64::from(dims[a]) - 0.5)
}

/// The columns of a row whose points are inside the volume.
pub(in crate::reslice) fn inside(samples: &Samples, [y, d]: [f64; 2], width: usize, dims: [u32; 3]) -> Range<usize> {
    let holds = |column: usize| holds(samples.at(column as f64, y, d), dims);
    let start = samples.at(0.0, y, d);
    let (mut from, mut to) = (0.0_f64, width as f64);
    for a in 0..3 {
        let (low, high, step) = (-0.5 - start[a], f64::from(dims[a]) - 0.5 - start[a], samples.right[a]);
        if step == 0.0 {
            if !(low <= 0.0 && high >= 0.0) {
                return 0..0;
            }
            continue;
        }
        from = from.max((low / step).min(high / step));
        to = to.min((low / step).max(high / step) + 1.0);
    }
    // Both ends are widened by one column below: only what is empty even then is empty for certain.
    if from.is_nan() || to.is_nan() || from >= to + 2.0 {
        return 0..0;
    }
    // The quotients are off by a little; the rule itself decides at both ends.
    let mut from = (from.max(0.0) as usize).saturating_sub(1).min(width);
    let mut to = (to.max(0.0).min(width as f64) as usize + 1).min(width);
    while from < to && !holds(from) {
        from += 1;
    }
    while from < to && !holds(to - 1) {
        to -= 1;
    }
    from..to
}
