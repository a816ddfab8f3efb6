//! The filters over a row: point by point, or in blocks of eight with vector instructions.

use std::ops::Range;

use bus::volume::VolumeView;

use super::aligned::Separable;
use super::kernel::Kernel;
use super::patch::{Patches, Plan};
use super::phases::Phases;
use super::points::{CatmullRom, CubicSpline, UNIT, Weights, convolved, linear, nearest};
use super::region::Region;
use super::runs::Runs;
use super::source::Source;
use super::vector::{Cell, Vector};
use super::walk::{BITS, Spot, Walk};

/// What a filter draws.
pub(super) trait Draw {
    /// Samples all of it with `kernel`.
    fn draw<const N: usize>(&mut self, kernel: &impl Separable<N>);
}

/// Copies of `$source` as `$patch`.
macro_rules! from_copies {
    ($source:ident, $patch:ident) => {
        fn plan(&self, region: &Region, plan: &mut Plan) {
            plan.set(&self.$source, region);
        }

        fn fetch(&self, plan: &Plan, part: usize, parts: usize) {
            if let Some(vector) = self.vector {
                plan.fetch(&self.$source, vector, part, parts);
            }
        }

        fn copy(&self, plan: &Plan, patches: &mut Patches) {
            Vector::with(self.vector, || patches.$patch.copy(&self.$source, plan));
        }
    };
}

/// [`scene::Filter::Nearest`].
pub(super) struct Nearest<'a> {
    voxels: Source<'a, i16>,
    cell: Option<Cell<'a>>,
    vector: Option<Vector>,
}

impl<'a> Nearest<'a> {
    pub(super) fn new(voxels: Source<'a, i16>, volume: &VolumeView<'a>, vector: Option<Vector>) -> Self {
        Self {
            voxels,
            cell: vector.and_then(|vector| vector.cell(volume)),
            vector,
        }
    }
}

impl Kernel for Nearest<'_> {
    fn vector(&self) -> Option<Vector> {
        self.vector
    }

    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        walk.each(columns, line, |spot| nearest(&self.voxels, &spot));
    }

    fn whole_blocks(&self) -> Option<[f64; 2]> {
        self.cell.as_ref().map(|_| [0.0, 0.0])
    }

    fn blocks(&self, walk: &Walk, first: usize, line: &mut [f32]) {
        if let Some(cell) = &self.cell {
            cell.nearest(walk, first, line, &self.voxels);
        }
    }
}

/// [`scene::Filter::Linear`].
pub(super) struct Linear<'a> {
    voxels: Source<'a, i16>,
    cell: Option<Cell<'a>>,
    vector: Option<Vector>,
    /// Whether copies pay: where cubes are bricks. Eight taps of plain rows are read faster than sixteen rows are copied.
    copies: bool,
}

impl<'a> Linear<'a> {
    pub(super) fn new(voxels: Source<'a, i16>, volume: &VolumeView<'a>, vector: Option<Vector>) -> Self {
        Self {
            voxels,
            cell: vector.and_then(|vector| vector.cell(volume)),
            vector,
            copies: volume.layout.brick() == [4; 3],
        }
    }
}

impl Kernel for Linear<'_> {
    fn vector(&self) -> Option<Vector> {
        self.vector
    }

    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        walk.each(columns, line, |spot| linear(&self.voxels, &spot));
    }

    fn whole_blocks(&self) -> Option<[f64; 2]> {
        self.cell.as_ref().map(|_| [0.0, 0.0])
    }

    fn blocks(&self, walk: &Walk, first: usize, line: &mut [f32]) {
        if let Some(cell) = &self.cell {
            cell.linear(walk, first, line, &self.voxels);
        }
    }

    fn reach(&self) -> Option<i32> {
        self.copies.then_some(1)
    }

    from_copies!(voxels, shorts);

    fn copied(&self, patches: &Patches, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        match self.vector {
            Some(vector) => vector.linear(&patches.shorts, walk, columns, line),
            None => {
                let source = patches.shorts.source();
                walk.each(columns, line, |spot| linear(&source, &spot));
            }
        }
    }
}

impl Separable<1> for Nearest<'_> {
    type Stored = i16;

    fn source(&self) -> &Source<'_, i16> {
        &self.voxels
    }

    fn weights(&self, _: i32) -> [f32; 1] {
        [1.0]
    }

    fn first(spot: &Spot, axis: usize) -> i32 {
        // The highest bit of the fraction says whether the next voxel is as near or nearer.
        spot.whole[axis] + (spot.part[axis] >> (BITS - 1))
    }
}

impl Separable<2> for Linear<'_> {
    type Stored = i16;

    fn source(&self) -> &Source<'_, i16> {
        &self.voxels
    }

    fn weights(&self, part: i32) -> [f32; 2] {
        let t = part as f32 * UNIT;
        [1.0 - t, t]
    }
}

/// Point by point, compiled for the vector unit where there is one.
macro_rules! points_by {
    ($self:ident, $walk:ident, $columns:ident, $line:ident, $value:expr) => {
        Vector::with($self.vector, || {
            $walk.each($columns, $line, |spot: Spot| $value(&spot));
        })
    };
}

/// [`scene::Filter::Cubic`].
pub(super) struct Cubic<'a> {
    pub(super) voxels: Source<'a, i16>,
    pub(super) runs: Option<Runs<'a, i16>>,
    pub(super) vector: Option<Vector>,
}

impl Kernel for Cubic<'_> {
    fn vector(&self) -> Option<Vector> {
        self.vector
    }

    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        match &self.runs {
            Some(runs) => runs.draw(self.vector, walk, columns, line, CatmullRom::at),
            None => points_by!(self, walk, columns, line, |spot| convolved(
                &self.voxels,
                spot,
                &CatmullRom::at(spot.part)
            )),
        }
    }

    fn reach(&self) -> Option<i32> {
        Some(2)
    }

    from_copies!(voxels, floats);

    fn copied(&self, patches: &Patches, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        match self.vector {
            Some(vector) => vector.four_taps::<CatmullRom>(&patches.floats, walk, columns, line),
            None => {
                let source = patches.floats.source();
                walk.each(columns, line, |spot| {
                    convolved(&source, &spot, &CatmullRom::at(spot.part))
                });
            }
        }
    }
}

impl Separable<4> for Cubic<'_> {
    type Stored = i16;

    fn source(&self) -> &Source<'_, i16> {
        &self.voxels
    }

    fn weights(&self, part: i32) -> [f32; 4] {
        CatmullRom::at([part])[0]
    }
}

/// [`scene::Filter::BSpline`].
pub(super) struct BSpline<'a> {
    pub(super) coefficients: Source<'a, f32>,
    pub(super) runs: Option<Runs<'a, f32>>,
    pub(super) vector: Option<Vector>,
}

impl Kernel for BSpline<'_> {
    fn vector(&self) -> Option<Vector> {
        self.vector
    }

    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        match &self.runs {
            Some(runs) => runs.draw(self.vector, walk, columns, line, CubicSpline::at),
            None => points_by!(self, walk, columns, line, |spot| convolved(
                &self.coefficients,
                spot,
                &CubicSpline::at(spot.part)
            )),
        }
    }

    fn reach(&self) -> Option<i32> {
        Some(2)
    }

    from_copies!(coefficients, floats);

    fn copied(&self, patches: &Patches, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        match self.vector {
            Some(vector) => vector.four_taps::<CubicSpline>(&patches.floats, walk, columns, line),
            None => {
                let source = patches.floats.source();
                walk.each(columns, line, |spot| {
                    convolved(&source, &spot, &CubicSpline::at(spot.part))
                });
            }
        }
    }
}

impl Separable<4> for BSpline<'_> {
    type Stored = f32;

    fn source(&self) -> &Source<'_, f32> {
        &self.coefficients
    }

    fn weights(&self, part: i32) -> [f32; 4] {
        CubicSpline::at([part])[0]
    }
}

/// [`scene::Filter::Sinc3`] and [`scene::Filter::Sinc5`].
pub(super) struct Sinc<'a, const N: usize> {
    pub(super) voxels: Source<'a, i16>,
    pub(super) phases: &'a Phases<N>,
    pub(super) vector: Option<Vector>,
}

impl<const N: usize> Kernel for Sinc<'_, N> {
    fn vector(&self) -> Option<Vector> {
        self.vector
    }

    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        points_by!(self, walk, columns, line, |spot| convolved(
            &self.voxels,
            spot,
            &spot.part.map(|part| self.phases.at(part))
        ));
    }

    fn reach(&self) -> Option<i32> {
        Some(N as i32 / 2)
    }

    from_copies!(voxels, floats);

    fn copied(&self, patches: &Patches, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        let source = patches.floats.source();
        points_by!(self, walk, columns, line, |spot| convolved(
            &source,
            spot,
            &spot.part.map(|part| self.phases.at(part))
        ));
    }
}

impl<const N: usize> Separable<N> for Sinc<'_, N> {
    type Stored = i16;

    fn source(&self) -> &Source<'_, i16> {
        &self.voxels
    }

    fn weights(&self, part: i32) -> [f32; N] {
        self.phases.at(part)
    }
}
