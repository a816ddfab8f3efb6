//! Why views of a grid give no camera.

use super::model::NAMES;

/// What a number that all views share is called.
fn name(parameter: usize) -> &'static str {
    NAMES.get(parameter).copied().unwrap_or("the bend of the plate, mm")
}

/// Why a calibration was refused. Views and discs count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraRefused {
    /// The image has no pixels, or more than a file can say.
    #[error("an image of {width} x {height} pixels; each side must have 1 to 100000")]
    BadSize {
        /// Columns of pixels.
        width: usize,
        /// Rows of pixels.
        height: usize,
    },
    /// Fewer views than hold the camera.
    #[error("{found} views; at least {needed} are needed, with the grid tilted differently in each")]
    TooFewViews {
        /// Views given.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// More views than are adjusted together with a plate's field.
    #[error("{found} views; with a field of the plate at most {most} are adjusted")]
    TooManyForField {
        /// Views given.
        found: usize,
        /// The greatest number.
        most: usize,
    },
    /// A view shows too little of the grid.
    #[error("view {view} has {found} discs; at least {needed} are needed")]
    TooFewDiscs {
        /// The first such view.
        view: usize,
        /// Its discs.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// A number is NaN, infinite, or a radius is not above zero.
    #[error("view {view}, disc {disc}: its place, pixel or radius is not a finite number, or the radius not above 0")]
    NotFinite {
        /// The view.
        view: usize,
        /// The disc.
        disc: usize,
    },
    /// A disc lies further outside the image than the image is large.
    #[error("view {view}, disc {disc}: pixel {pixel:?} is far outside the image of {width} x {height}")]
    OffImage {
        /// The view.
        view: usize,
        /// The disc.
        disc: usize,
        /// Where it is said to be.
        pixel: [f64; 2],
        /// Columns of pixels.
        width: usize,
        /// Rows of pixels.
        height: usize,
    },
    /// A covariance is not symmetric positive definite.
    #[error("view {view}, disc {disc}: the covariance is not symmetric positive definite")]
    BadCovariance {
        /// The view.
        view: usize,
        /// The disc.
        disc: usize,
    },
    /// The discs of a view lie on a line, in the grid or in the image: no homography.
    #[error("view {view}: its {discs} discs lie on a line or on one point, in the grid or in the image")]
    Singular {
        /// The view.
        view: usize,
        /// Its discs.
        discs: usize,
    },
    /// Two views are one and the same: the noise of one would count twice.
    #[error("views {first} and {second} are the same: their discs lie within {apart_px:.1e} px of one another")]
    Identical {
        /// The first of them.
        first: usize,
        /// The second.
        second: usize,
        /// The greatest distance of a disc.
        apart_px: f64,
    },
    /// The grid has the same direction in all views: any focal length fits.
    #[error(
        "the grid lies parallel in all {views} views: their planes differ by {spread_deg:.2} degrees at most, \
         {needed_deg} are needed"
    )]
    Parallel {
        /// Number of views.
        views: usize,
        /// The largest angle of two of their planes.
        spread_deg: f64,
        /// The least that is taken.
        needed_deg: f64,
    },
    /// Fewer numbers measured than asked for.
    #[error("{measured} coordinates measured for {unknowns} unknowns")]
    NoFreedom {
        /// Two a disc.
        measured: usize,
        /// Those of the camera and six a view.
        unknowns: usize,
    },
    /// The views leave a number of the camera free.
    #[error("the views hardly hold {}: {value:.4e} with a deviation of {sigma:.1e}", name(*.parameter))]
    Weak {
        /// Its place in [`NAMES`]; beyond them the plate's numbers.
        parameter: usize,
        /// Its value.
        value: f64,
        /// Its deviation; infinite where it is free.
        sigma: f64,
    },
    /// Too many discs far from where the camera sees them.
    #[error(
        "{rejected} of {discs} discs lie more than {gate} deviations from where the camera sees them; {allowed} may be \
         left out. The worst: view {view}, disc {disc}, {worst_px:.2} px"
    )]
    Outliers {
        /// Discs that would be left out.
        rejected: usize,
        /// All.
        discs: usize,
        /// The gate, standard deviations.
        gate: f64,
        /// How many may be left out.
        allowed: usize,
        /// The view of the worst.
        view: usize,
        /// The worst.
        disc: usize,
        /// Its distance.
        worst_px: f64,
    },
    /// The lens' polynomial turns back among the discs seen: no camera.
    #[error(
        "view {view}, disc {disc} lies {tangent:.4} off the axis (tangent of its angle), where the lens' polynomial has \
         turned back at {limit:.4}; free fewer coefficients"
    )]
    Folded {
        /// The view.
        view: usize,
        /// The disc.
        disc: usize,
        /// Tangent of its angle off the axis.
        tangent: f64,
        /// Where the domain ends.
        limit: f64,
    },
    /// The grid is not flat, and was taken for flat.
    #[error(
        "the grid is not flat: its discs lie up to {sag_mm:.2} mm off a plane, and {rms_px:.2} px RMS from where a camera \
         sees them that knows of the bend. Taken for flat: {flat}"
    )]
    NotFlat {
        /// The greatest height of a disc over the plane, mm.
        sag_mm: f64,
        /// What residuals are left with the plate bent.
        rms_px: f64,
        /// Why there is no camera with a flat one.
        flat: Box<CameraRefused>,
    },
    /// The sizes of the plate's field change from round to round.
    #[error(
        "the size of the plate's field does not settle in {rounds} rounds: {height_mm:.1e} mm in height and {plane_mm:.1e} mm in \
         the plane, the last change {change:.1e} of it"
    )]
    FieldUnsettled {
        /// Rounds made.
        rounds: usize,
        /// The size in height, mm.
        height_mm: f64,
        /// The size along each axis of the plane, mm.
        plane_mm: f64,
        /// The last change of either as a share of it.
        change: f64,
    },
    /// The iteration did not settle.
    #[error("no convergence after {steps} steps (last step {last:.1e} standard deviations)")]
    NoConvergence {
        /// The steps made.
        steps: usize,
        /// The last, in units of its standard deviation.
        last: f64,
    },
}
