//! The filters over a row: point by point, or in blocks of eight with vector instructions.

use std::ops::Range;

use bus::volume::VolumeView;

use super::phases::Phases;
use super::points::{b_spline, convolved, cubic, linear, nearest};
use super::source::Source;
use super::vector::{Cell, Vector};
use super::walk::{LANES, Walk};

/// A filter with what it reads.
pub(super) trait Kernel {
    /// Draws `columns`, one after the other.
    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]);

    /// If it can do whole blocks at once: how far before and behind a point its taps lie, voxels.
    fn whole_blocks(&self) -> Option<[f64; 2]> {
        None
    }

    /// Draws whole blocks from block `first` on, all of them within [`Kernel::whole_blocks`] of the outermost voxels.
    fn blocks(&self, walk: &Walk, first: usize, line: &mut [f32]) {
        self.points(walk, first * LANES..first * LANES + line.len(), line);
    }
}

/// [`bus::scene::Filter::Nearest`].
pub(super) struct Nearest<'a> {
    voxels: Source<'a, i16>,
    cell: Option<Cell<'a>>,
}

impl<'a> Nearest<'a> {
    pub(super) fn new(voxels: Source<'a, i16>, volume: &VolumeView<'a>, vector: Option<Vector>) -> Self {
        Self {
            voxels,
            cell: vector.and_then(|vector| vector.cell(volume)),
        }
    }
}

impl Kernel for Nearest<'_> {
    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        for (column, value) in columns.zip(line) {
            *value = nearest(&self.voxels, &walk.at(column));
        }
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

/// [`bus::scene::Filter::Linear`].
pub(super) struct Linear<'a> {
    voxels: Source<'a, i16>,
    cell: Option<Cell<'a>>,
}

impl<'a> Linear<'a> {
    pub(super) fn new(voxels: Source<'a, i16>, volume: &VolumeView<'a>, vector: Option<Vector>) -> Self {
        Self {
            voxels,
            cell: vector.and_then(|vector| vector.cell(volume)),
        }
    }
}

impl Kernel for Linear<'_> {
    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        for (column, value) in columns.zip(line) {
            *value = linear(&self.voxels, &walk.at(column));
        }
    }

    fn whole_blocks(&self) -> Option<[f64; 2]> {
        self.cell.as_ref().map(|_| [0.0, 0.0])
    }

    fn blocks(&self, walk: &Walk, first: usize, line: &mut [f32]) {
        if let Some(cell) = &self.cell {
            cell.linear(walk, first, line, &self.voxels);
        }
    }
}

/// Point by point, compiled for the vector unit where there is one.
macro_rules! points_by {
    ($self:ident, $walk:ident, $columns:ident, $line:ident, $value:expr) => {
        Vector::with($self.vector, || {
            for (column, value) in $columns.zip($line) {
                let spot = $walk.at(column);
                *value = $value(&spot);
            }
        })
    };
}

/// [`bus::scene::Filter::Cubic`].
pub(super) struct Cubic<'a> {
    pub(super) voxels: Source<'a, i16>,
    pub(super) vector: Option<Vector>,
}

impl Kernel for Cubic<'_> {
    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        points_by!(self, walk, columns, line, |spot| convolved(&self.voxels, spot, &cubic(spot)));
    }
}

/// [`bus::scene::Filter::BSpline`].
pub(super) struct BSpline<'a> {
    pub(super) coefficients: Source<'a, f32>,
    pub(super) vector: Option<Vector>,
}

impl Kernel for BSpline<'_> {
    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        points_by!(self, walk, columns, line, |spot| convolved(
            &self.coefficients,
            spot,
            &b_spline(spot)
        ));
    }
}

/// [`bus::scene::Filter::Sinc3`] and [`bus::scene::Filter::Sinc5`].
pub(super) struct Sinc<'a, const N: usize> {
    pub(super) voxels: Source<'a, i16>,
    pub(super) phases: &'a Phases<N>,
    pub(super) vector: Option<Vector>,
}

impl<const N: usize> Kernel for Sinc<'_, N> {
    fn points(&self, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
        points_by!(self, walk, columns, line, |spot| convolved(
            &self.voxels,
            spot,
            &self.phases.at(spot)
        ));
    }
}
