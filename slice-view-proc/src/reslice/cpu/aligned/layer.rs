//! Across the plane: lines of voxels, each summed up over the layers that a filter reaches.

use std::ops::Range;

use super::super::runs::Run;
use super::super::source::{Source, Value};
use super::super::vector::Vector;
use super::super::walk::Spot;
use super::{Axes, QUAD, Separable};

/// Marks a quad whose voxels do not lie side by side, or as far apart as rows of a brick: at the border, in planes along z,
/// and in other layouts than bricks of four.
const SCATTERED: u32 = u32::MAX;

/// Where the voxels of a row lie: four at a time.
#[derive(Debug, Clone, Default)]
pub(super) struct Quads {
    /// The offset term of each quad's first voxel.
    terms: Vec<u32>,
    /// From one voxel of a quad to the next; 0 where they lie anywhere.
    step: u32,
}

impl Quads {
    /// Those of `reach`, a multiple of four voxels along `axis`.
    pub(super) fn set<V: Value>(&mut self, source: &Source<'_, V>, axis: usize, reach: Range<i32>) {
        let (quads, _) = source.table(axis, reach).as_chunks::<QUAD>();
        let step = |quad: &[u32; QUAD]| {
            let step = quad[1].checked_sub(quad[0])?;
            let even = (1..QUAD).all(|i| quad[i] == quad[0] + i as u32 * step);
            (even && [1, 4].contains(&step)).then_some(step)
        };
        // One step for the whole line, so that the loop over quads has no choice to make.
        self.step = quads.iter().find_map(step).unwrap_or(0);
        self.terms.clear();
        let terms = quads.iter().map(|quad| match step(quad) {
            Some(found) if found == self.step => quad[0],
            _ => SCATTERED,
        });
        self.terms.extend(terms);
    }
}

/// Some neighbouring lines of a layer, in groups of [`QUAD`].
#[derive(Debug, Clone, Default)]
pub(super) struct Layer {
    /// The group that each place holds.
    held: Vec<Option<i32>>,
    /// The last one that was summed up.
    last: i32,
    sums: Vec<f32>,
}

/// Where a group of lines is held: those that `N` neighbours are in have different places.
fn place<const N: usize>(group: i32) -> usize {
    // Groups before voxel 0 have numbers below zero.
    group.rem_euclid(places::<N>() as i32) as usize
}

/// The most groups that `N` neighbours are in.
const fn places<const N: usize>() -> usize {
    // Most where the first is the last line of its group: the other `N - 1` lines, in groups rounded up, and that one.
    (N + QUAD - 2) / QUAD + 1
}

/// The group of a line.
fn group(voxel: i32) -> i32 {
    voxel.div_euclid(QUAD as i32)
}

/// What lines are summed up from.
struct Sum<'a, V, const N: usize> {
    source: &'a Source<'a, V>,
    quads: &'a Quads,
    /// The offset terms of the voxels along the row.
    along: &'a [u32],
    weights: [f32; N],
    /// The offset terms of the layers that the filter reaches.
    layers: [usize; N],
}

impl Layer {
    pub(super) fn clear(&mut self) {
        self.held.clear();
    }

    /// The sums of line `voxel`, once held.
    pub(super) fn line<const N: usize>(&self, voxel: i32, count: usize) -> &[f32] {
        let lines = place::<N>(group(voxel)) * QUAD + voxel.rem_euclid(QUAD as i32) as usize;
        &self.sums[lines * count..][..count]
    }

    /// Sums up the voxels across the plane along `N` lines from `first` on, but for those that are held.
    #[inline(always)]
    pub(super) fn hold<const N: usize, K: Separable<N>>(
        &mut self,
        kernel: &K,
        axes: Axes,
        spot: &Spot,
        first: i32,
        (quads, reach): (&Quads, Range<i32>),
    ) {
        let lines = QUAD * reach.len();
        self.held.resize(places::<N>(), None);
        self.sums.resize(places::<N>() * lines, 0.0);
        for group in group(first)..=group(first + N as i32 - 1) {
            // All rows of a layer have the same place across the plane: sums stay right from row to row.
            let place = place::<N>(group);
            // Rows next to one another share all lines but one: what is there is not summed again.
            if self.held[place].replace(group) == Some(group) {
                continue;
            }
            let source = kernel.source();
            let sum = Sum {
                source,
                quads,
                along: source.table(axes.right, reach.clone()),
                weights: kernel.weights(spot.part[axes.across]),
                layers: source.terms(axes.across, K::first(spot, axes.across)),
            };
            sum.lines(
                kernel.vector(),
                axes.down,
                group,
                &mut self.sums[place * lines..][..lines],
            );
            // Rows go one way: the memory of the next line is asked for while this one is used.
            let next = group + if group < self.last { -1 } else { 1 };
            self.last = group;
            if let Some(vector) = kernel.vector() {
                sum.fetch(vector, axes.down, next);
            }
        }
    }
}

impl<V: Run, const N: usize> Sum<'_, V, N> {
    /// The lines of a group, one after the other.
    #[inline(always)]
    fn lines(&self, vector: Option<Vector>, axis: usize, group: i32, sums: &mut [f32]) {
        let downs: [usize; QUAD] = self.source.terms(axis, group * QUAD as i32);
        for (down, sums) in downs.into_iter().zip(sums.chunks_exact_mut(self.along.len())) {
            self.line(vector, down, sums);
        }
    }

    /// One line.
    #[inline(always)]
    fn line(&self, vector: Option<Vector>, down: usize, sums: &mut [f32]) {
        let rest = |i: usize, sums: &mut [f32]| self.scattered(down, i * QUAD..(i + 1) * QUAD, sums);
        let (values, reads, terms) = (self.source.values, self.reads(down), &self.quads.terms);
        match (vector, self.quads.step) {
            (Some(vector), 1) => vector.across::<V, N, 1>(values, reads, terms, sums, rest),
            (Some(vector), 4) => vector.across::<V, N, 4>(values, reads, terms, sums, rest),
            _ => self.scattered(down, 0..sums.len(), sums),
        }
    }

    fn reads(&self, down: usize) -> ([f32; N], [usize; N]) {
        (self.weights, self.layers.map(|layer| layer + down))
    }

    /// Asks for the memory of a group to come. Along x neighbours lie in one stream, which processors foresee by themselves.
    #[inline(always)]
    fn fetch(&self, vector: Vector, axis: usize, group: i32) {
        if self.quads.step == 1 {
            return;
        }
        // Two lines of a brick are in one line of the cache.
        for down in [0, 2].map(|l| self.source.term(axis, group * QUAD as i32 + l)) {
            let Some(down) = down else { return };
            for term in self.quads.terms.iter().filter(|term| **term != SCATTERED) {
                for layer in self.layers {
                    vector.fetch_one(self.source.values, *term as usize + layer + down);
                }
            }
        }
    }

    /// Some voxels of a line, wherever they lie.
    #[inline(always)]
    fn scattered(&self, down: usize, voxels: Range<usize>, sums: &mut [f32]) {
        for (sum, term) in sums[voxels.clone()].iter_mut().zip(&self.along[voxels]) {
            *sum = 0.0;
            for (weight, layer) in self.weights.iter().zip(self.layers) {
                *sum += weight * self.source.values[layer + down + *term as usize].hu();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn neighbours_have_places<const N: usize>() {
        for first in -9..9 {
            let groups = || group(first)..=group(first + N as i32 - 1);
            let held: std::collections::HashSet<_> = groups().map(place::<N>).collect();
            assert_eq!(held.len(), groups().count(), "{N} from {first}");
        }
    }

    #[test]
    fn groups_that_are_needed_together_do_not_share_a_place() {
        neighbours_have_places::<1>();
        neighbours_have_places::<2>();
        neighbours_have_places::<4>();
        neighbours_have_places::<6>();
        neighbours_have_places::<10>();
    }
}
