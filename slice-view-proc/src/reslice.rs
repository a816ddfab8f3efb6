//! Sampling a plane out of the volume.
//!
//! **What a pixel is.** Its centre has a continuous voxel index v. With [`Minify::Area`] a pixel larger than a voxel is the
//! mean of points spread evenly over it, at most one voxel apart; with a [`Slab`] these means are taken at depths spread
//! evenly through the thickness, at most one voxel apart, and their mean, maximum or minimum is the pixel ([`Samples`]).
//!
//! **Border rule**, the same for every back end and filter: the volume is the union of its voxels' cells, so a point is
//! inside when -1/2 <= v <= n - 1/2 on every axis. Points outside are left out; a pixel all of whose points are
//! outside has the padding value. Filters that reach beyond the outermost voxel centres see the outermost voxels
//! repeated, and [`Filter::BSpline`] sees the volume mirrored about the outermost voxel centres, as is usual for it.
//!
//! [`Minify::Area`]: scene::Minify::Area
//! [`Slab`]: scene::Slab

mod choice;
mod cpu;
mod gpu;
mod opening;
mod pace;
mod proving;
mod reference;
mod samples;
mod spline;
mod watch;
mod weights;

use bus::volume::VolumeView;
use geometry::SlicePlane;
use scene::{Filter, Sampling};

pub use choice::Chosen;
pub use cpu::Cpu;
pub(crate) use cpu::{Vector, Work};
pub use gpu::{Gpu, Timings};
pub use reference::Reference;
pub use samples::Samples;

/// A way of sampling a plane. Back ends differ in speed and in the error they state, never in the border rule.
pub trait Resampler {
    /// The name in reports, with the device where there is a choice.
    fn name(&self) -> &str;

    /// What every image drawn this way must say; empty while all is as the scene asked.
    fn caution(&self) -> &'static str {
        ""
    }

    /// The largest distance of a result from the f64 reference, HU, for voxels up to `max_abs_hu` in magnitude.
    ///
    /// For [`Filter::Nearest`] it holds away from ties: where an index lies in the middle between two voxels to within
    /// the back end's rounding (1.2e-7 of a voxel for [`Cpu`]), either of the two may be given.
    fn error_bound_hu(&self, sampling: &Sampling, max_abs_hu: f64) -> f64;

    /// Makes ready for sampling `volume` in these ways. Long work calls `alive` several times a second.
    ///
    /// # Errors
    /// [`ResliceError`].
    fn prepare(
        &mut self,
        volume: &VolumeView<'_>,
        samplings: &[Sampling],
        alive: &mut dyn FnMut(),
    ) -> Result<(), ResliceError>;

    /// Samples `plane` into `hu`, row by row; `hu` holds width x height values.
    ///
    /// # Errors
    /// [`ResliceError`].
    fn reslice(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
    ) -> Result<(), ResliceError>;

    /// Samples the volume at `places`, mm in the CT's frame, one value to each: single points, neither means over areas nor slabs;
    /// outside the volume the padding.
    ///
    /// # Errors
    /// [`ResliceError`].
    fn reslice_at(
        &mut self,
        _volume: &VolumeView<'_>,
        _places: &[[f32; 3]],
        _filter: Filter,
        _hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        Err(ResliceError::PlanesOnly)
    }
}

/// Why a plane was not sampled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ResliceError {
    /// This back end samples planes, and no single places.
    #[error("this back end samples planes, not single places")]
    PlanesOnly,
    /// This filter needs [`Resampler::prepare`] first, for this volume.
    #[error("the {} filter was not prepared for this volume", .0.name())]
    NotPrepared(Filter),
    /// What the filter keeps of the volume is larger than this process may take.
    #[error("the {} filter keeps {needed} bytes of this volume; {allowed} are free. Use another filter", filter.name())]
    Memory {
        /// The filter.
        filter: Filter,
        /// Bytes that it would take.
        needed: u64,
        /// Bytes that there are.
        allowed: u64,
    },
    /// The graphics card failed, or is too small.
    #[error("the GPU failed: {0}")]
    Gpu(String),
}
