//! The fast CPU back end: fixed-point positions, f32 weights, one thread; eight pixels at a time where the CPU has AVX2.
//!
//! Planes along the volume's axes are summed axis by axis (`aligned`). Others are drawn tile by tile from copies of the voxels
//! about each tile (`tiles`, `region`, `patch`), while the memory of the next tile is on its way; slabs, averages
//! over large pixels, and tiles too large for a copy, from the volume itself.
//!
//! Both ways give the same bits, so that a picture does not depend on the machine (see `walk` and `points`).

mod aligned;
mod image;
mod kernel;
mod kernels;
mod patch;
mod phases;
mod points;
mod region;
mod runs;
mod scattered;
mod source;
mod tiles;
mod vector;
pub(in crate::reslice) mod walk;

use bus::volume::VolumeView;
use geometry::SlicePlane;
use scene::{Filter, Sampling};

use super::spline::{self, Spline};
use super::weights::{gain, steepness};
use super::{Resampler, ResliceError};
use image::{Fold, Image};
use kernels::Draw;
use phases::Phases;
use runs::Runs;
use scattered::Scattered;
use source::{Source, Tables};
pub(crate) use vector::{Vector, Work};

/// The fast back end on one CPU core.
#[derive(Debug, Clone)]
pub struct Cpu {
    vector: Option<Vector>,
    tables: Tables,
    spline_tables: Tables,
    spline: Option<Spline<f32>>,
    sinc3: Option<Phases<6>>,
    sinc5: Option<Phases<10>>,
    fold: Fold,
}

impl Default for Cpu {
    fn default() -> Self {
        Self::with(Vector::detect())
    }
}

impl Cpu {
    /// The back end without vector instructions: the same bits, more slowly.
    pub fn portable() -> Self {
        Self::with(None)
    }

    /// The coefficients that it was prepared with, where it needs them.
    pub(in crate::reslice) fn spline(&self) -> Option<&Spline<f32>> {
        self.spline.as_ref()
    }

    fn with(vector: Option<Vector>) -> Self {
        Self {
            vector,
            tables: Tables::default(),
            spline_tables: Tables::default(),
            spline: None,
            sinc3: None,
            sinc5: None,
            fold: Fold::default(),
        }
    }

    /// Samples the volume at `places`, mm in the CT's frame, one value to each, of both as many as there are of fewer: single points, without slabs or means over areas. Where
    /// a place is outside the volume, or no number, the value is the padding.
    ///
    /// It is within [`Resampler::error_bound_hu`] of [`super::Reference::reslice_at`] at the same places.
    ///
    /// # Errors
    /// [`ResliceError::NotPrepared`].
    pub fn reslice_at(
        &mut self,
        volume: &VolumeView<'_>,
        places: &[[f32; 3]],
        filter: Filter,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        self.tables.repeated(volume);
        self.draw(volume, filter, &mut Scattered { volume, places, hu })
    }

    fn draw(&self, volume: &VolumeView<'_>, filter: Filter, drawing: &mut impl Draw) -> Result<(), ResliceError> {
        let voxels = Source::new(volume.voxels, &self.tables);
        let missing = || ResliceError::NotPrepared(filter);
        let vector = self.vector;
        // Each filter's loop is compiled for it: what is drawn is chosen here, once, and not at every pixel.
        match filter {
            Filter::Nearest => drawing.draw(&kernels::Nearest::new(voxels, volume, vector)),
            Filter::Linear => drawing.draw(&kernels::Linear::new(voxels, volume, vector)),
            Filter::Cubic => {
                let runs = Runs::new(voxels, volume.layout, volume.grid.dims()[0]);
                drawing.draw(&kernels::Cubic { voxels, runs, vector });
            }
            Filter::BSpline => {
                let spline = self.spline.as_ref().filter(|s| s.is_of(volume)).ok_or_else(missing)?;
                let coefficients = Source::new(&spline.coefficients, &self.spline_tables);
                let runs = Runs::new(coefficients, &spline.layout, volume.grid.dims()[0]);
                drawing.draw(&kernels::BSpline {
                    coefficients,
                    runs,
                    vector,
                });
            }
            Filter::Sinc3 => {
                let phases = self.sinc3.as_ref().ok_or_else(missing)?;
                drawing.draw(&kernels::Sinc { voxels, phases, vector });
            }
            Filter::Sinc5 => {
                let phases = self.sinc5.as_ref().ok_or_else(missing)?;
                drawing.draw(&kernels::Sinc { voxels, phases, vector });
            }
        }
        Ok(())
    }
}

impl Resampler for Cpu {
    fn name(&self) -> &str {
        match self.vector {
            Some(_) => "cpu, AVX2",
            None => "cpu",
        }
    }

    fn error_bound_hu(&self, sampling: &Sampling, max_abs_hu: f64) -> f64 {
        let half_ulp = f64::from(f32::EPSILON) / 2.0;
        let taps = sampling.filter.taps() as f64;
        // Roundings on the way to one value, in half ulp of the largest result.
        let roundings = match sampling.filter {
            // The same voxel: see the trait for indices in the middle between two.
            Filter::Nearest => 0.0,
            // Three nested a + (b - a) w: each rounds its product (up to twice the largest value) and its sums.
            Filter::Linear => 14.0,
            // Per axis: the four weights together are off by 10, and there is a product and a sum per tap.
            Filter::Cubic => 3.0 * (10.0 + taps + 1.0),
            // The same, and coefficients that were rounded after each of three axes.
            Filter::BSpline => 3.0 * (10.0 + taps + 1.0) + 3.0,
            // A weight from the table of phases is off by 1.25 for its straight line and 2 for its roundings.
            Filter::Sinc3 | Filter::Sinc5 => 3.0 * (3.25 * taps + taps + 1.0),
        };
        // An index is off by 2^-24 of a voxel on each axis, which is half an ulp of 1.
        let unit = roundings * gain(sampling.filter) + steepness(sampling.filter);
        max_abs_hu * half_ulp * (unit + gain(sampling.filter))
    }

    fn prepare(
        &mut self,
        volume: &VolumeView<'_>,
        samplings: &[Sampling],
        alive: &mut dyn FnMut(),
    ) -> Result<(), ResliceError> {
        let wanted = |filter| samplings.iter().any(|s| s.filter == filter);
        self.sinc3 = wanted(Filter::Sinc3).then(|| Phases::new(Filter::Sinc3));
        self.sinc5 = wanted(Filter::Sinc5).then(|| Phases::new(Filter::Sinc5));
        self.spline = None;
        if wanted(Filter::BSpline) {
            spline::check_memory::<f32>(volume)?;
            let spline = Spline::new(volume, alive);
            self.spline_tables.mirrored(&spline);
            self.spline = Some(spline);
        }
        Ok(())
    }

    fn reslice_at(
        &mut self,
        volume: &VolumeView<'_>,
        places: &[[f32; 3]],
        filter: Filter,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        Self::reslice_at(self, volume, places, filter, hu)
    }

    fn reslice(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        // Tables belong to a layout: a volume that was loaded anew may have another.
        self.tables.repeated(volume);
        let mut fold = std::mem::take(&mut self.fold);
        let mut image = Image::new(volume, plane, sampling, &mut fold, hu);
        let drawn = self.draw(volume, sampling.filter, &mut image);
        self.fold = fold;
        drawn
    }
}

#[cfg(test)]
mod tests;
