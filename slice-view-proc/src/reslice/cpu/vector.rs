//! AVX2: eight pixels at a time. The only folder of this crate with unsafe code.
//!
//! Every operation is the one of the portable code (`points`, `walk`) in the same order, so the bits are the same: no
//! product is fused with a sum. What can be wrong is only where it reads: see [`Cell`].
#![allow(
    unsafe_code,
    reason = "gathers read by address; each offset is checked against the slice"
)]

#[cfg(target_arch = "x86_64")]
mod across;
#[cfg(target_arch = "x86_64")]
mod along;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod dense;
mod proof;

use std::ops::Range;

use bus::volume::{Steps, VolumeView};

use super::aligned::Columns;
use super::patch::Patch;
use super::points::Weights;
use super::runs::{RUN, Run, Runs};
use super::source::Source;
use super::walk::{LANES, Walk};
pub(crate) use proof::{Vector, Work};

/// What blocks of eight are read with.
///
/// Reads are safe whatever the positions: voxel numbers are clamped into the volume, the offset of a voxel inside the
/// volume is below `voxels.len()` by the layout's construction (checked once, at the last voxel, since offsets grow
/// along each axis), and as a gather reads four bytes for a value of two, a block that would touch the very last value
/// is left to the portable code.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell<'a> {
    voxels: &'a [i16],
    steps: [Steps; 3],
    /// The largest voxel number on each axis, less one: the last cell.
    last_cell: [i32; 3],
}

impl Vector {
    /// [`Runs::draw`] with vector instructions.
    pub(super) fn with_runs<V: Run>(
        self,
        runs: &Runs<'_, V>,
        walk: &Walk,
        columns: Range<usize>,
        line: &mut [f32],
        weights: impl Fn([i32; 3]) -> [[f32; RUN]; 3],
    ) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `self` is the proof that this CPU has AVX2.
        unsafe {
            avx2::runs(runs, walk, columns, line, weights);
        }
    }

    /// Sums up a line of quads of values, each at its term after each of `layers`, `STEP` (1 or 4) apart. What cannot be read
    /// like that is left to `rest`, with its number.
    #[inline(always)]
    pub(super) fn across<V: Run, const N: usize, const STEP: usize>(
        self,
        values: &[V],
        reads: ([f32; N], [usize; N]),
        terms: &[u32],
        sums: &mut [f32],
        rest: impl FnMut(usize, &mut [f32]),
    ) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `self` is the proof that this CPU has AVX2.
        unsafe {
            across::across::<V, N, STEP>(values, reads, terms, sums, rest);
        }
    }

    /// Weighs the values of a line into the columns of a row; see [`Columns::draw`].
    #[inline(always)]
    pub(super) fn along<const N: usize>(self, columns: &Columns, values: &[f32], line: &mut [f32]) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `self` is the proof that this CPU has AVX2.
        unsafe {
            along::along::<N>(columns, values, line);
        }
    }

    /// Trilinear, from a patch.
    pub(super) fn linear(self, patch: &Patch<i16>, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `self` is the proof that this CPU has AVX2.
        unsafe {
            dense::linear(patch, walk, columns, line);
        }
    }

    /// A filter of four taps, from a patch.
    pub(super) fn four_taps<W: Weights>(
        self,
        patch: &Patch<f32>,
        walk: &Walk,
        columns: Range<usize>,
        line: &mut [f32],
    ) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        unsafe {
            dense::four_taps::<W>(patch, walk, columns, line);
        }
    }

    /// What is needed to read `volume` in blocks; `None` for volumes it cannot address or without a cell.
    pub(super) fn cell<'a>(self, volume: &VolumeView<'a>) -> Option<Cell<'a>> {
        let dims = volume.grid.dims();
        let last = volume.layout.offset(dims.map(|n| n - 1));
        let addressable = volume.voxels.len() <= i32::MAX as usize && last < volume.voxels.len();
        let cell = Cell {
            voxels: volume.voxels,
            steps: std::array::from_fn(|a| volume.layout.steps(a)),
            last_cell: dims.map(|n| n as i32 - 2),
        };
        (addressable && dims.iter().all(|&n| n >= 2)).then_some(cell)
    }
}

impl Cell<'_> {
    /// Draws the blocks from `first` on into `line`.
    pub(super) fn linear(&self, walk: &Walk, first: usize, line: &mut [f32], exact: &Source<'_, i16>) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a cell is only made by a `Vector`, which is the proof that this CPU has AVX2.
        unsafe {
            avx2::linear(self, walk, first, line, exact);
        }
    }

    /// The same for the nearest voxel.
    pub(super) fn nearest(&self, walk: &Walk, first: usize, line: &mut [f32], exact: &Source<'_, i16>) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        unsafe {
            avx2::nearest(self, walk, first, line, exact);
        }
    }
}
