//! The ways in which candidates are looked for: what smooths the image first.

use nalgebra::Vector2;

use crate::grid::candidates::blob::{Blob, blobs};
use crate::grid::candidates::grazing::{SLOPES, along_discs, direction};
use crate::image::{Image, Plane, halved, smoothed};

/// How many ways there are.
pub(crate) const WAYS: usize = 4;
/// Smoothing of the whole image where all else shows no grid at a grazing angle, pixels.
const GRAZING_SIGMA_PX: f64 = 1.4;
/// Smoothing at half the resolution, its pixels: what nearly every grid is found in, and for much noise.
const HALF_RESOLUTION_SIGMAS_PX: [f64; 2] = [0.8, 1.2];

/// The ways to an image's candidates, the most promising first.
///
/// At half the resolution nearly every grid is found, in a quarter of the time: what is found there is but a start for the
/// fit to the image itself. Smaller discs ask for the whole resolution: where one direction stands out, as it does at a
/// grazing angle, smoothing along it comes first, as it takes as much noise and less of the discs. More smoothing comes
/// last, at half the resolution where no direction stands out.
pub(crate) struct SmoothingPasses<'a> {
    image: &'a Image,
    noise: f64,
    bright: bool,
    /// The image as slopes are taken in it, and the direction of the least ones, once they are needed.
    slopes: Option<(Plane, Option<Vector2<f64>>)>,
}

impl<'a> SmoothingPasses<'a> {
    /// Of an image whose noise has the deviation `noise`.
    pub(crate) fn new(image: &'a Image, noise: f64, bright: bool) -> Self {
        Self {
            image,
            noise,
            bright,
            slopes: None,
        }
    }

    /// The candidates of one of the [`WAYS`]; none where it has nothing to look at.
    pub(crate) fn candidates(&mut self, way: usize) -> Option<Vec<Blob>> {
        if way == 0 {
            return self.half(HALF_RESOLUTION_SIGMAS_PX[0]);
        }
        let (image, noise) = (self.image, self.noise);
        let (plane, direction) = self.slopes.get_or_insert_with(|| {
            let plane = smoothed(image, SLOPES);
            let direction = direction(&plane, noise);
            (plane, direction)
        });
        match (way, *direction) {
            (1, Some(direction)) => {
                let (plane, left) = along_discs(image, direction, noise);
                Some(blobs(&plane, left, self.bright))
            }
            (1, None) | (2, Some(_)) => Some(blobs(plane, left(noise, SLOPES), self.bright)),
            (_, Some(_)) => Some(blobs(
                &smoothed(image, GRAZING_SIGMA_PX),
                left(noise, GRAZING_SIGMA_PX),
                self.bright,
            )),
            (2, None) => self.half(HALF_RESOLUTION_SIGMAS_PX[1]),
            (_, None) => None,
        }
    }

    fn half(&self, sigma: f64) -> Option<Vec<Blob>> {
        // `gain` grey levels for one: the noise of a mean of four is half of a pixel's.
        let (half, gain) = halved(self.image)?;
        let found = blobs(
            &smoothed(&half, sigma),
            left(0.5 * gain * self.noise, sigma),
            self.bright,
        );
        Some(found.into_iter().map(|b| doubled(b, gain)).collect())
    }
}

/// What a Gaussian leaves of white noise: 1 / (2 sqrt(pi) sigma) of its deviation.
fn left(noise: f64, sigma: f64) -> f64 {
    // The integral of the kernel's square; for a kernel narrower than a pixel it would tell of more noise than there
    // was.
    (noise / (2.0 * std::f64::consts::PI.sqrt() * sigma)).min(noise)
}

/// From the pixels of half the resolution, whose samples have `gain` times the steps, to those of the image.
fn doubled(blob: Blob, gain: f64) -> Blob {
    Blob {
        // Pixel k of the half is the mean of 2 k and 2 k + 1, whose middle is 2 k + 1/2.
        at: blob.at * 2.0 + Vector2::repeat(0.5),
        shape: blob.shape * 4.0,
        area: blob.area * 4.0,
        depth: blob.depth / gain,
        cut: blob.cut,
    }
}
