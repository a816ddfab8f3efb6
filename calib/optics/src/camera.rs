//! Calibration of a camera from several views of a grid of discs (Zhang 2000): focal lengths, principal point and the
//! lens' distortion, with the grid's place in every view and the covariance of it all.
//!
//! 1. The homography of each view; the focal lengths from all of them in closed form, the principal point in the middle.
//!    Views that cannot hold the camera are refused by name ([`CameraRefused::Parallel`], [`CameraRefused::Identical`],
//!    [`CameraRefused::Singular`]).
//! 2. Levenberg and Marquardt's method on everything at once, every disc weighted by its covariance, poses eliminated.
//! 3. Discs beyond the gate are left out, and the rest is adjusted again.
//! 4. Where the plate may have a field ([`Options::field`]), all of it together once more. Where a flat plate leads nowhere
//!    and a bent one does, that is what the refusal says ([`CameraRefused::NotFlat`]).
//!
//! A disc is seen at the image of its centre or by the centre of its image ([`Sighting::radius_mm`]): perspective and
//! the lens move one from the other by hundredths of a pixel for a radius of ten pixels.
//!
//! The covariances are those of the deviations given, grown to the residuals' size where that is larger
//! ([`Calibrated::noise_ratio`]). They do not know of a lens that the model does not describe, or of a grid that is bent
//! unless [`Options::bent`] or [`Options::field`] has its shape adjusted too; [`held_out()`] tells whether more numbers describe more.
//! Nor do they know of pictures by two cameras: so [`Gates`] refuse residuals above 3 deviations, and views that say as different things
//! of the camera ([`Calibrated::view_ratio`]), and [`agreeing`] says which views agree.
//!
//! Lengths of the grid in millimetres, of the image in pixels, angles in radians.
//!
//! ```
//! use optics::camera::{Camera, Lens, Outside};
//! use geometry::Point;
//! use nalgebra::Vector2;
//!
//! let lens = Lens { k1: -0.3, ..Lens::default() };
//! let camera = Camera { lens, ..Camera::pinhole(1000.0, Vector2::new(639.5, 359.5)) };
//! let pixel = camera.project(Point::new(30.0, -12.0, 100.0))?;
//! let ray = camera.undistort(pixel)?;
//! assert!((ray - Vector2::new(0.3, -0.12)).norm() < 1e-12);
//! assert!(matches!(camera.project(Point::new(200.0, 0.0, 100.0)), Err(Outside::Wide { .. })));
//! # Ok::<(), Outside>(())
//! ```

mod adjust;
mod agree;
mod apart;
mod choice;
mod coverage;
mod error;
mod fitted;
mod full_hessian;
mod held_out;
mod joint_adjust;
mod lens;
mod model;
mod normal;
mod paraboloid;
mod plate;
mod plate_bend;
mod plate_field;
mod predict;
mod result;
mod start;
mod state;
mod view;

pub use agree::{Agreeing, agreeing};
pub use coverage::{CELLS, Coverage, Gates, Short};
pub use error::CameraRefused;
pub use held_out::held_out;
pub use lens::{LEAST_SLOPE, Lens, WIDEST};
pub use model::{Camera, CameraFrame, GridFrame, NAMES, Outside, PARAMETERS};
pub use plate::{Plate, PlateField};
pub use plate_field::REACH;
pub use result::{Calibrated, Posed, Residual};
pub use start::LEAST_SPREAD_DEG;
pub use view::{ImageSize, LEAST_DISCS, LEAST_VIEWS, LensModel, Options, Sighting, View};

use adjust::Problem;
use choice::Chosen;
use paraboloid::Ruler;
use plate_field::Waves;
use view::Station;

/// Calibrates a camera from views of a grid.
///
/// # Errors
/// Each variant of [`CameraRefused`].
pub fn calibrate(views: &[View], size: ImageSize, options: &Options) -> Result<Calibrated, CameraRefused> {
    once(views, size, options).map_err(|refused| plate_bend::told(refused, views, size, options))
}

/// [`calibrate`], without a second try.
fn once(views: &[View], size: ImageSize, options: &Options) -> Result<Calibrated, CameraRefused> {
    let (mut stations, chosen) = settled(views, size, options)?;
    if let Some(field) = &chosen.field {
        stations = field.waves.moved(&stations, &field.coefficients);
    }
    Calibrated::of(&chosen, &stations, views, size, options)
}

/// The views made ready, and the adjustment's end.
fn settled(views: &[View], size: ImageSize, options: &Options) -> Result<(Vec<Station>, Chosen), CameraRefused> {
    view::check(views, size, options)?;
    let ruler = Ruler::of(plate::places(views));
    let stations: Vec<Station> = views.iter().map(|v| Station::of(v, &ruler)).collect();
    let problem = Problem {
        stations: &stations,
        free: options.shared(),
    };
    let starts = start::starts(&stations, size, |state| problem.cost(state))?;
    let chosen = choice::adjusted(&stations, starts, options)?;
    if !options.field {
        return Ok((stations, chosen));
    }
    let chosen = choice::fielded(&stations, chosen, &Waves::of(&stations, ruler), options)?;
    Ok((stations, chosen))
}
