//! Filters of four taps on planes in any direction: four neighbours along x from one or two runs of memory.
//!
//! In bricks, four aligned neighbours lie side by side. Four neighbours from anywhere lie in one or two such runs: both
//! are read as eight values, weighted along y and z, and only then the four are picked out. The sums are those of
//! [`convolved`] in the same order, so the bits are the same.

use std::ops::Range;

use super::points::convolved;
use super::source::{Source, Value};
use super::vector::Vector;
use super::walk::{Spot, Walk};

pub(super) const RUN: usize = 4;

/// What is sampled, and where its runs begin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Runs<'a, V> {
    pub(super) source: Source<'a, V>,
    /// Voxels along x.
    pub(super) width: i32,
    /// Runs begin at multiples of four (bricks), or anywhere (rows).
    pub(super) aligned: bool,
}

/// A stored value that vector code can read four of.
pub(super) trait Run: Value {
    /// Whether these are 16-bit integers; else they are f32.
    const IS_SHORT: bool;
}
impl Run for i16 {
    const IS_SHORT: bool = true;
}
impl Run for f32 {
    const IS_SHORT: bool = false;
}

impl<'a, V: Run> Runs<'a, V> {
    /// `None` for a layout whose runs are shorter than four.
    pub(super) fn new(source: Source<'a, V>, layout: &bus::volume::Layout, width: u32) -> Option<Self> {
        let side = layout.brick()[0] as usize;
        (side == 1 || side >= RUN).then_some(Self {
            source,
            width: i32::try_from(width).ok()?,
            aligned: side >= RUN,
        })
    }

    /// Where the taps' two runs begin, and how far the first tap is into them; `None` at the border.
    #[inline(always)]
    fn begin(&self, spot: &Spot) -> Option<([usize; 2], usize)> {
        let first = spot.whole[0] - 1;
        // There neighbours are repeated or mirrored voxels, which lie in no run.
        if first < 0 || first + RUN as i32 > self.width {
            return None;
        }
        let skip = if self.aligned { first % RUN as i32 } else { 0 };
        let [a] = self.source.terms::<1>(0, first - skip);
        let b = if skip > 0 {
            self.source.terms::<1>(0, first - skip + RUN as i32)[0]
        } else {
            a
        };
        Some(([a, b], skip as usize))
    }

    /// Draws `columns`; `weights` are those of the three axes.
    pub(super) fn draw(
        &self,
        vector: Option<Vector>,
        walk: &Walk,
        columns: Range<usize>,
        line: &mut [f32],
        weights: impl Fn([i32; 3]) -> [[f32; RUN]; 3],
    ) {
        match vector {
            Some(vector) => vector.with_runs(self, walk, columns, line, weights),
            None => walk.each(columns, line, |spot| {
                convolved(&self.source, &spot, &weights(spot.part))
            }),
        }
    }

    /// Where the sixteen runs of a point begin, if there are such: along x two, along y and z four.
    #[inline(always)]
    pub(super) fn places(&self, spot: &Spot) -> Option<Places> {
        let (x, skip) = self.begin(spot)?;
        let y: [usize; RUN] = self.source.terms(1, spot.whole[1] - 1);
        let z: [usize; RUN] = self.source.terms(2, spot.whole[2] - 1);
        let most = |terms: &[usize]| terms.iter().fold(0, |most, &term| most.max(term));
        // One comparison for all sums: the largest terms bound every one of them.
        let end = most(&x) + most(&y) + most(&z) + RUN;
        (end <= self.source.values.len()).then_some(Places { x, y, z, skip })
    }
}

/// Offset terms: every sum of one of each, and three more, lies within the values.
pub(super) struct Places {
    pub(super) x: [usize; 2],
    pub(super) y: [usize; RUN],
    pub(super) z: [usize; RUN],
    /// The first tap's place in the first run.
    pub(super) skip: usize,
}
