//! Why a disc was not found or fitted.

/// Why a disc was not fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitRefused {
    /// The place to start from is no ellipse, or too large.
    #[error(
        "semi-axes {semi:?} px with a blur of {sigma} px are not what a disc is fitted from (above 0, at most 400)"
    )]
    BadStart {
        /// Semi-axes, pixels.
        semi: [f64; 2],
        /// Blur, pixels.
        sigma: f64,
    },
    /// The disc lies outside the image or nearly so.
    #[error("{found} pixels see the disc; at least {needed} are needed")]
    TooFewPixels {
        /// Pixels in the window.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// The disc does not stand out.
    #[error("the contrast {found:.2} is not three deviations above its error at a noise of {noise:.2}")]
    NoContrast {
        /// Disc less surroundings, grey levels.
        found: f64,
        /// Residuals' deviation.
        noise: f64,
    },
    /// The iteration did not settle.
    #[error("no convergence after {steps} steps")]
    NoConvergence {
        /// Steps made.
        steps: usize,
    },
    /// The best fit is elsewhere.
    #[error("the fit moved {moved:.2} px; the disc was looked for within {reach:.2} px")]
    RanAway {
        /// Distance from the start, pixels.
        moved: f64,
        /// The farthest allowed, pixels.
        reach: f64,
    },
}

/// Why no discs were looked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DetectRefused {
    /// The radii are not an interval.
    #[error("radii from {least} to {greatest} px: they must be finite, from 1 to 200, the first at most the second")]
    BadRadii {
        /// The least, pixels.
        least: f64,
        /// The greatest, pixels.
        greatest: f64,
    },
    /// The ring is not there.
    #[error("a ring of {found} px: it must be 1 to 100 px wide")]
    BadRing {
        /// Its width, pixels.
        found: f64,
    },
    /// The image is smaller than the smallest disc with its ring.
    #[error(
        "an image of {width} x {height} pixels holds no disc of radius {radius} px with its surroundings ({needed} pixels across)"
    )]
    TooSmall {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// The least radius, pixels.
        radius: f64,
        /// The least side, pixels.
        needed: usize,
    },
}
