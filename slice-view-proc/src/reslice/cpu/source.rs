//! What the kernels read: values and one offset table per axis that reaches beyond the volume.

use std::ops::Range;

use bus::volume::VolumeView;

use super::super::reference::mirrored;
use super::super::spline::Spline;

/// Entries of a table before voxel 0 and after the last: the widest filter at the outermost half voxel, in groups of four.
pub(super) const APRON: usize = 8;

/// A stored value.
pub(super) trait Value: Copy {
    fn hu(self) -> f32;
}

impl Value for i16 {
    #[inline(always)]
    fn hu(self) -> f32 {
        f32::from(self)
    }
}

impl Value for f32 {
    #[inline(always)]
    fn hu(self) -> f32 {
        self
    }
}

/// One offset term per voxel and axis, continued beyond the outermost voxels by the border rule.
#[derive(Debug, Clone, Default)]
pub(super) struct Tables([Vec<u32>; 3]);

impl Tables {
    /// Outermost voxels repeated.
    pub(super) fn repeated(&mut self, volume: &VolumeView<'_>) {
        for (axis, table) in self.0.iter_mut().enumerate() {
            let terms = volume.layout.table(axis);
            let n = terms.len() as i64;
            fill(table, n, |i| terms[i.clamp(0, n - 1) as usize]);
        }
    }

    /// Mirrored about the outermost centres.
    pub(super) fn mirrored(&mut self, spline: &Spline<f32>) {
        for (axis, table) in self.0.iter_mut().enumerate() {
            let terms = spline.layout.table(axis);
            fill(table, terms.len() as i64, |i| terms[mirrored(i, terms.len() as i64)]);
        }
    }
}

fn fill(table: &mut Vec<u32>, n: i64, term: impl Fn(i64) -> u32) {
    let apron = APRON as i64;
    table.clear();
    table.extend((-apron..n + apron).map(term));
}

/// Values in place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a, V> {
    pub(super) values: &'a [V],
    tables: [&'a [u32]; 3],
    /// The index that each table begins at.
    first: [i32; 3],
}

impl<'a, V: Value> Source<'a, V> {
    pub(super) fn new(values: &'a [V], tables: &'a Tables) -> Self {
        Self::from_parts(values, tables.0.each_ref().map(Vec::as_slice), [-(APRON as i32); 3])
    }

    /// Values with one table of offset terms per axis that begins at index `first`.
    pub(super) fn from_parts(values: &'a [V], tables: [&'a [u32]; 3], first: [i32; 3]) -> Self {
        Self { values, tables, first }
    }

    /// The offset terms of the voxels in `reach` along `axis`.
    #[inline(always)]
    pub(super) fn table(&self, axis: usize, reach: Range<i32>) -> &'a [u32] {
        let at = |i: i32| (i - self.first[axis]) as usize;
        &self.tables[axis][at(reach.start)..at(reach.end)]
    }

    /// The offset term of the voxel at index `i`, if there is one.
    #[inline(always)]
    pub(super) fn term(&self, axis: usize, i: i32) -> Option<usize> {
        let at = usize::try_from(i - self.first[axis]).ok()?;
        self.tables[axis].get(at).map(|&term| term as usize)
    }

    /// The offset terms of `N` voxels in a row along `axis`, the first of them at index `first`, which may be negative.
    #[inline(always)]
    pub(super) fn terms<const N: usize>(&self, axis: usize, first: i32) -> [usize; N] {
        let at = (first - self.first[axis]) as usize;
        let terms: &[u32] = &self.tables[axis][at..at + N];
        std::array::from_fn(|k| terms[k] as usize)
    }
}
