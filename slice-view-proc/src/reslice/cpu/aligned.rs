//! Planes along the volume's own axes, which six of the seven usual images are: the filter is applied axis by axis.
//!
//! A row of such an image crosses one line of voxels. First the voxels across the plane are summed up (once per voxel and
//! image), then the lines above and below the row, then the voxels along it. So a filter of N taps costs about 3 N products
//! a pixel and not N^3. Sums run in this order on every machine.

use std::ops::Range;

use super::super::Samples;
use super::source::{Source, Value};
use super::walk::{Spot, Walk};

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
pub(super) trait Separable<const N: usize> {
    /// What is stored.
    type Stored: Value;

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
    /// The columns that `first` and `weights` are for.
    columns: Range<usize>,
    /// Of each column: its first voxel, counted from that of the leftmost tap.
    first: Vec<u32>,
    /// For one tap: the offset term of each column.
    single: Vec<u32>,
    /// Of each column: its `N` weights.
    weights: Vec<f32>,
    /// The voxels that the row reaches.
    reach: Range<i32>,
    /// Per layer: `N` lines of sums across the plane.
    layers: Vec<Layer>,
    row: Vec<f32>,
}

#[derive(Debug, Clone, Default)]
struct Layer {
    /// The line of voxels that each place holds.
    held: Vec<Option<i32>>,
    sums: Vec<f32>,
}

impl Lines {
    /// Forgets the last image.
    pub(super) fn restart(&mut self, depths: u32) {
        self.columns = 0..0;
        self.layers.resize_with(depths as usize, Layer::default);
        self.layers.iter_mut().for_each(|layer| layer.held.clear());
    }

    /// Draws the inside of row `walk` of layer `d` into `line`.
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
        if self.columns != walk.inside {
            self.set_columns(kernel, axes, walk);
        }
        let spot = walk.at(walk.inside.start);
        if N == 1 {
            return self.draw_single(kernel, axes, &spot, d, &mut line[walk.inside.clone()]);
        }
        let (n, first) = (self.reach.len(), K::first(&spot, axes.down));
        for voxel in first..first + N as i32 {
            self.layers[d as usize].hold(kernel, axes, &spot, voxel, &self.reach);
        }
        let layer = &self.layers[d as usize];
        let weights = kernel.weights(spot.part[axes.down]);
        self.row.clear();
        self.row.resize(n, 0.0);
        for (voxel, weight) in (first..).zip(weights) {
            let place = place::<N>(voxel) * n;
            for (sum, value) in self.row.iter_mut().zip(&layer.sums[place..place + n]) {
                *sum += weight * value;
            }
        }
        self.along::<N>(&mut line[walk.inside.clone()]);
    }

    /// A filter of one tap, whose weight is one: the voxels themselves.
    #[inline(always)]
    fn draw_single<const N: usize, K: Separable<N>>(
        &mut self,
        kernel: &K,
        axes: Axes,
        spot: &Spot,
        d: u32,
        line: &mut [f32],
    ) {
        let source = kernel.source();
        let layer = &mut self.layers[d as usize];
        let voxel = K::first(spot, axes.down);
        layer.held.resize(1, None);
        if layer.held[0].replace(voxel) != Some(voxel) {
            let [down] = source.terms::<1>(axes.down, voxel);
            let [across] = source.terms::<1>(axes.across, K::first(spot, axes.across));
            let values = &source.values[down + across..];
            layer.sums.clear();
            layer
                .sums
                .extend(self.single.iter().map(|&at| values[at as usize].hu()));
        }
        line.copy_from_slice(&layer.sums);
    }

    /// The last sums, along the row.
    #[inline(always)]
    fn along<const N: usize>(&self, line: &mut [f32]) {
        let (weights, _) = self.weights.as_chunks::<N>();
        for ((value, first), weights) in line.iter_mut().zip(&self.first).zip(weights) {
            let voxels = &self.row[*first as usize..*first as usize + N];
            let mut sum = 0.0;
            for (voxel, weight) in voxels.iter().zip(weights) {
                sum += weight * voxel;
            }
            *value = sum;
        }
    }

    fn set_columns<const N: usize, K: Separable<N>>(&mut self, kernel: &K, axes: Axes, walk: &Walk) {
        let firsts = || walk.inside.clone().map(|column| K::first(&walk.at(column), axes.right));
        let (low, high) = firsts().fold((i32::MAX, i32::MIN), |(low, high), i| (low.min(i), high.max(i)));
        self.columns = walk.inside.clone();
        self.reach = low..high + N as i32;
        self.first.clear();
        self.first.extend(firsts().map(|i| (i - low) as u32));
        if N == 1 {
            let along = kernel.source().table(axes.right, self.reach.clone());
            self.single.clear();
            self.single.extend(self.first.iter().map(|&i| along[i as usize]));
        }
        self.weights.clear();
        let weights = walk
            .inside
            .clone()
            .map(|column| kernel.weights(walk.at(column).part[axes.right]));
        self.weights.extend(weights.flatten());
        self.layers.iter_mut().for_each(|layer| layer.held.clear());
    }
}

/// Where a line of voxels is held: `N` neighbours have `N` different places.
fn place<const N: usize>(voxel: i32) -> usize {
    voxel.rem_euclid(N as i32) as usize
}

impl Layer {
    /// Sums up the voxels across the plane along line `voxel`, unless they are held already.
    #[inline(always)]
    fn hold<const N: usize, K: Separable<N>>(
        &mut self,
        kernel: &K,
        axes: Axes,
        spot: &Spot,
        voxel: i32,
        reach: &Range<i32>,
    ) {
        let n = reach.len();
        self.held.resize(N, None);
        self.sums.resize(N * n, 0.0);
        if self.held[place::<N>(voxel)].replace(voxel) == Some(voxel) {
            return;
        }
        let source = kernel.source();
        let [down] = source.terms::<1>(axes.down, voxel);
        let across: [usize; N] = source
            .terms(axes.across, K::first(spot, axes.across))
            .map(|term: usize| term + down);
        let weights = kernel.weights(spot.part[axes.across]);
        let along = source.table(axes.right, reach.clone());
        let sums = &mut self.sums[place::<N>(voxel) * n..][..n];
        for (sum, term) in sums.iter_mut().zip(along) {
            *sum = 0.0;
            for k in 0..N {
                *sum += weights[k] * source.values[across[k] + *term as usize].hu();
            }
        }
    }
}
