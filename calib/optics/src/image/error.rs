//! Why there is no image.

use super::MAX_PIXELS;

/// Why samples are not an image.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImageError {
    /// A side is 0.
    #[error("the image has {width} x {height} pixels: there is nothing in it")]
    Empty {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// There are more pixels than are taken.
    #[error(
        "the image has {width} x {height} pixels; at most {MAX_PIXELS} (8192 x 8192) are taken: crop it or make it smaller"
    )]
    TooLarge {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Samples and size do not agree.
    #[error("{samples} samples for an image of {width} x {height} pixels")]
    Length {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Samples found.
        samples: usize,
    },
    /// A sample is NaN or infinite.
    #[error("the pixel x {x}, y {y} is {found}: not a finite number")]
    NotFinite {
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// The sample.
        found: f32,
    },
}
