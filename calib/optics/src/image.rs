//! Grey images as the detectors take them: whole numbers of 8 to 16 bits, with pixel centres at whole coordinates, x to
//! the right and y down, both from 0.

mod error;
mod half;
mod noise;
mod smooth;
mod sums;

pub use error::ImageError;
pub(crate) use half::halved;
pub use noise::noise_deviation;
pub use smooth::{Plane, smoothed};
pub use sums::Sums;

/// The most pixels of an image: 8192 x 8192. Sums of squares of 16-bit samples over it stay below 2^58.
pub const MAX_PIXELS: usize = 1 << 26;

/// A grey image. Samples are whole numbers 0 to 65535; `value = zero + step * sample` in the units of its source.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    samples: Vec<u16>,
    step: f64,
    zero: f64,
}

impl Image {
    /// From samples row by row.
    ///
    /// # Errors
    /// [`ImageError`]: no pixel, too many, or not `width * height` samples.
    pub fn new(width: usize, height: usize, samples: Vec<u16>) -> Result<Self, ImageError> {
        check(width, height, samples.len())?;
        Ok(Self {
            width,
            height,
            samples,
            step: 1.0,
            zero: 0.0,
        })
    }

    /// From 8-bit samples row by row.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub fn from_bytes(width: usize, height: usize, samples: &[u8]) -> Result<Self, ImageError> {
        Self::new(width, height, samples.iter().map(|s| u16::from(*s)).collect())
    }

    /// From real numbers row by row, in 65536 steps between the least and the greatest.
    ///
    /// # Errors
    /// As [`Image::new`], and [`ImageError::NotFinite`] with the place of the first NaN or infinity.
    pub fn from_reals(width: usize, height: usize, values: &[f32]) -> Result<Self, ImageError> {
        check(width, height, values.len())?;
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            let (x, y, found) = (i % width, i / width, values[i]);
            return Err(ImageError::NotFinite { x, y, found });
        }
        let bounds = values.iter().fold([f64::MAX, f64::MIN], |[low, high], v| {
            [low.min(f64::from(*v)), high.max(f64::from(*v))]
        });
        // An image of one value has no range: with any step its samples are 0.
        let step = ((bounds[1] - bounds[0]) / 65535.0).max(f64::MIN_POSITIVE);
        let sample = |v: &f32| ((f64::from(*v) - bounds[0]) / step).round() as u16;
        Ok(Self {
            width,
            height,
            samples: values.iter().map(sample).collect(),
            step,
            zero: bounds[0],
        })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The samples, row by row.
    pub fn samples(&self) -> &[u16] {
        &self.samples
    }

    /// A row's samples; empty outside the image.
    pub fn row(&self, y: usize) -> &[u16] {
        let start = y.saturating_mul(self.width);
        self.samples.get(start..start + self.width).unwrap_or_default()
    }

    /// The sample at a place; 0 outside the image.
    #[inline]
    pub fn sample(&self, x: usize, y: usize) -> u16 {
        self.row(y).get(x).copied().unwrap_or(0)
    }

    /// Whether a place lies between the outermost pixels' centres.
    pub(crate) fn holds(&self, at: nalgebra::Vector2<f64>) -> bool {
        at.x > 0.0 && at.y > 0.0 && at.x < self.width as f64 - 1.0 && at.y < self.height as f64 - 1.0
    }

    /// What one step of a sample is, in the units of the source.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The value of sample 0, in the units of the source.
    pub fn zero(&self) -> f64 {
        self.zero
    }
}

fn check(width: usize, height: usize, samples: usize) -> Result<(), ImageError> {
    let pixels = width.checked_mul(height).filter(|n| *n <= MAX_PIXELS);
    let pixels = pixels.ok_or(ImageError::TooLarge { width, height })?;
    if pixels == 0 {
        return Err(ImageError::Empty { width, height });
    }
    if samples != pixels {
        return Err(ImageError::Length { width, height, samples });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_image_is_refused() {
        let text = |result: Result<Image, ImageError>| result.unwrap_err().to_string();
        assert!(text(Image::new(0, 5, vec![])).contains("0 x 5"));
        assert!(text(Image::new(2, 2, vec![0; 3])).contains("3 samples"));
        assert!(text(Image::new(20_000, 20_000, vec![])).contains("20000 x 20000"));
        assert!(text(Image::new(usize::MAX, 2, vec![])).contains("at most"));
        let nan = text(Image::from_reals(2, 2, &[0.0, 1.0, f32::NAN, 2.0]));
        assert!(nan.contains("x 0, y 1") && nan.contains("NaN"), "{nan}");
    }

    #[test]
    fn reals_are_kept_to_half_a_step() {
        let values = [-3.5_f32, 0.25, 7.0, 100.0];
        let image = Image::from_reals(2, 2, &values).unwrap();
        for (value, sample) in values.iter().zip(image.samples()) {
            let back = image.zero() + image.step() * f64::from(*sample);
            assert!((back - f64::from(*value)).abs() <= 0.5001 * image.step());
        }
        assert_eq!(Image::from_reals(1, 1, &[4.0]).unwrap().samples(), [0]);
    }
}
