//! Planes along the volume's own axes, which six of the seven usual images are: the filter is applied axis by axis.
//!
//! A row of such an image crosses one line of voxels. First the voxels across the plane are summed up (once per voxel and
//! image), then the lines above and below the row, then the voxels along it. So a filter of N taps costs about 3 N products
//! a pixel and not N^3. Sums run in this order on every machine.

mod columns;
mod layer;

use super::super::Samples;
use super::kernel::Kernel;
use super::runs::Run;
use super::source::Source;
use super::walk::{Spot, Walk};
pub(super) use columns::Columns;
use layer::{Layer, Quads};

/// Voxels that are summed up together.
pub(super) const QUAD: usize = 4;

/// Over the whole image a step may stray by this from the axis it follows, voxels: far less than positions are rounded.
const STRAY: f64 = 1e-9;

/// Which axis of the volume is which of the plane's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Axes {
    right: usize,
    down: usize,
    across: usize,
}

impl Axes {
    /// The axes of a plane along the volume's; `None` for any other plane.
    pub(super) fn of(samples: &Samples, [width, height]: [usize; 2]) -> Option<Self> {
        let right = only_axis(samples.right, width)?;
        let down = only_axis(samples.down, height)?;
        // The three numbers sum to 3. For one axis twice that may be below zero, or else is refused below.
        let across = 3_usize.checked_sub(right + down)?;
        let straight = samples.depths == 1 || only_axis(samples.into, samples.depths as usize) == Some(across);
        (right != down && straight).then_some(Self { right, down, across })
    }
}

/// The one axis along which `step` moves.
fn only_axis(step: [f64; 3], count: usize) -> Option<usize> {
    let moves = |a: &usize| step[*a].abs() * count as f64 > STRAY;
    let mut axes = (0..3).filter(moves);
    let axis = axes.next()?;
    axes.next().is_none().then_some(axis)
}

/// A filter that is a product of `N` weights an axis.
pub(super) trait Separable<const N: usize>: Kernel {
    /// What is stored.
    type Stored: Run;

    /// What it reads.
    fn source(&self) -> &Source<'_, Self::Stored>;

    /// Weights at a fraction.
    fn weights(&self, part: i32) -> [f32; N];

    /// The voxel of the first weight.
    fn first(spot: &Spot, axis: usize) -> i32 {
        spot.whole[axis] + 1 - N as i32 / 2
    }
}

/// Buffers, taken once.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines {
    columns: Columns,
    quads: Quads,
    /// Per layer: `N` lines of sums across the plane.
    layers: Vec<Layer>,
    /// Sums across the plane and down.
    row: Vec<f32>,
    /// For a filter of one tap: the row that is drawn again and again.
    pixels: Vec<f32>,
    /// The layer and the line of voxels of that row.
    drawn: Option<(u32, i32)>,
}

impl Lines {
    /// Forgets the last image.
    pub(super) fn restart(&mut self, depths: u32) {
        self.drawn = None;
        self.columns.clear();
        self.layers.resize_with(depths as usize, Layer::default);
        self.layers.iter_mut().for_each(Layer::clear);
    }

    /// Draws row `walk` of layer `d`, as far as it is inside, into `line`.
    #[inline(always)]
    pub(super) fn draw<const N: usize, K: Separable<N>>(
        &mut self,
        kernel: &K,
        axes: Axes,
        walk: &Walk,
        d: u32,
        line: &mut [f32],
    ) {
        if walk.inside.is_empty() {
            return;
        }
        // In one image rows move along one axis only: with the same columns inside they have the same places along it.
        if !self.columns.are_of(walk) {
            self.columns.set(kernel, axes, walk);
            self.quads.set(kernel.source(), axes.right, self.columns.reach());
            self.layers.iter_mut().for_each(Layer::clear);
            self.drawn = None;
        }
        let spot = walk.at(walk.inside.start);
        let (layer, first) = (&mut self.layers[d as usize], K::first(&spot, axes.down));
        let line = &mut line[walk.inside.clone()];
        // One tap has weight one: rows of the same voxels are the same.
        if N == 1 && self.drawn == Some((d, first)) {
            return line.copy_from_slice(&self.pixels);
        }
        layer.hold(kernel, axes, &spot, first, (&self.quads, self.columns.reach()));
        self.sum_down::<N>(d, first, kernel.weights(spot.part[axes.down]));
        self.columns.draw::<N>(kernel.vector(), &self.row, line);
        if N == 1 {
            self.drawn = Some((d, first));
            self.pixels.clear();
            self.pixels.extend_from_slice(line);
        }
    }

    /// Sums up the lines from `first` on.
    #[inline(always)]
    fn sum_down<const N: usize>(&mut self, d: u32, first: i32, weights: [f32; N]) {
        let count = self.columns.reach().len();
        self.row.clear();
        self.row.resize(self.columns.room::<N>(), 0.0);
        for (voxel, weight) in (first..).zip(weights) {
            let values = self.layers[d as usize].line::<N>(voxel, count);
            for (sum, value) in self.row.iter_mut().zip(values) {
                *sum += weight * value;
            }
        }
    }
}
