//! The f64 reference: plain code, one point at a time, the oracle of every other back end.

use bus::volume::VolumeView;
use geometry::{Point, SlicePlane};
use scene::{Filter, Sampling, SlabMode};

use super::spline::Spline;
use super::weights::{first_tap, gain, weights};
use super::{Resampler, ResliceError, Samples};

/// The reference back end.
#[derive(Debug, Default, Clone)]
pub struct Reference {
    spline: Option<Spline<f64>>,
}

impl Resampler for Reference {
    fn name(&self) -> &str {
        "cpu-reference-f64"
    }

    fn error_bound_hu(&self, sampling: &Sampling, max_abs_hu: f64) -> f64 {
        // The result is stored as f32.
        gain(sampling.filter) * max_abs_hu * f64::from(f32::EPSILON) / 2.0
    }

    fn prepare(
        &mut self,
        volume: &VolumeView<'_>,
        samplings: &[Sampling],
        alive: &mut dyn FnMut(),
    ) -> Result<(), ResliceError> {
        let wanted = samplings.iter().any(|s| s.filter == Filter::BSpline);
        self.spline = wanted.then(|| Spline::new(volume, alive));
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
        let samples = Samples::new(volume, plane, sampling);
        let source = self.source(volume, sampling.filter)?;
        let width = plane.size()[0] as usize;
        for (row, line) in hu.chunks_exact_mut(width).enumerate() {
            for (column, value) in line.iter_mut().enumerate() {
                let layers = (0..samples.depths).filter_map(|d| area(&source, &samples, [column, row], d));
                let pixel = through(sampling.slab.map_or(SlabMode::Mean, |s| s.mode), layers);
                *value = pixel.unwrap_or(f64::from(volume.padding_hu)) as f32;
            }
        }
        Ok(())
    }
}

impl Reference {
    /// Samples the volume at `places`, mm in the CT's frame, one value to each; outside the volume, the padding.
    ///
    /// # Errors
    /// [`ResliceError::NotPrepared`].
    pub fn reslice_at(
        &self,
        volume: &VolumeView<'_>,
        places: &[[f32; 3]],
        filter: Filter,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        let source = self.source(volume, filter)?;
        let voxel_from_ct = volume.grid.voxel_from_ct();
        for (place, value) in places.iter().zip(hu) {
            let [x, y, z] = place.map(f64::from);
            let found = source.sample((voxel_from_ct * Point::new(x, y, z)).mm());
            *value = found.unwrap_or(f64::from(volume.padding_hu)) as f32;
        }
        Ok(())
    }

    fn source<'a>(&'a self, volume: &'a VolumeView<'a>, filter: Filter) -> Result<Source<'a>, ResliceError> {
        let spline = self.spline.as_ref().filter(|s| s.is_of(volume));
        if filter == Filter::BSpline && spline.is_none() {
            return Err(ResliceError::NotPrepared(filter));
        }
        Ok(Source { volume, filter, spline })
    }
}

/// The mean over the points of one pixel in one layer that are inside.
fn area(source: &Source<'_>, samples: &Samples, [column, row]: [usize; 2], d: u32) -> Option<f64> {
    let [kx, ky] = samples.fold.map(|k| k as usize);
    let (mut sum, mut count) = (0.0, 0.0);
    for j in 0..ky {
        for i in 0..kx {
            let index = samples.at((column * kx + i) as f64, (row * ky + j) as f64, f64::from(d));
            if let Some(value) = source.sample(index) {
                sum += value;
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// What becomes of the layers that are inside.
fn through(mode: SlabMode, layers: impl Iterator<Item = f64>) -> Option<f64> {
    match mode {
        SlabMode::Maximum => layers.reduce(f64::max),
        SlabMode::Minimum => layers.reduce(f64::min),
        SlabMode::Mean => {
            let (sum, count) = layers.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
            (count > 0.0).then(|| sum / count)
        }
    }
}

/// What is sampled.
struct Source<'a> {
    volume: &'a VolumeView<'a>,
    filter: Filter,
    spline: Option<&'a Spline<f64>>,
}

impl Source<'_> {
    /// The HU at a continuous voxel index; `None` outside.
    fn sample(&self, index: [f64; 3]) -> Option<f64> {
        let dims = self.volume.grid.dims();
        if !(0..3).all(|a| index[a] >= -0.5 && index[a] <= f64::from(dims[a]) - 0.5) {
            return None;
        }
        if self.filter == Filter::Nearest {
            // At `dims - 1/2`, which still is inside, rounding up would name a voxel that does not exist.
            let voxel = std::array::from_fn(|a| ((index[a] + 0.5).floor() as u32).min(dims[a] - 1));
            return Some(f64::from(self.volume.at(voxel)));
        }
        let taps = self.filter.taps();
        let low = index.map(f64::floor);
        let w: [_; 3] = std::array::from_fn(|a| weights(self.filter, index[a] - low[a]));
        let mut sum = 0.0;
        for k in 0..taps {
            for j in 0..taps {
                for i in 0..taps {
                    let weight = w[0][i] * w[1][j] * w[2][k];
                    let at: [i64; 3] =
                        std::array::from_fn(|a| low[a] as i64 + [i, j, k][a] as i64 + first_tap(self.filter));
                    // Taps beyond the border weigh nothing and are not read.
                    if weight != 0.0 {
                        sum += weight * self.tap(at);
                    }
                }
            }
        }
        Some(sum)
    }

    /// The voxel, or the coefficient, at an index that may lie beyond the outermost ones.
    fn tap(&self, at: [i64; 3]) -> f64 {
        let dims = self.volume.grid.dims().map(i64::from);
        match self.spline.filter(|_| self.filter == Filter::BSpline) {
            None => {
                let voxel = std::array::from_fn(|a| at[a].clamp(0, dims[a] - 1) as u32);
                f64::from(self.volume.at(voxel))
            }
            Some(spline) => spline.at(std::array::from_fn(|a| mirrored(at[a], dims[a]) as u32)),
        }
    }
}

/// The index mirrored about the centres of the first and the last voxel.
pub(super) fn mirrored(i: i64, n: i64) -> usize {
    // A period of 0 has no remainder.
    if n == 1 {
        return 0;
    }
    let m = i.rem_euclid(2 * n - 2);
    m.min(2 * n - 2 - m) as usize
}
