//! Pivot calibration: where the tip of an instrument is in its marker, from poses of the marker while the tip stays in
//! place (thesis, part I, 2.3.2: the pointer of the calibration base).
//!
//! The tip `x` in the marker and the pivot `c` in the tracker satisfy `R_i x + t_i = c`.
//!
//! | method | minimises | bias by noise of the rotations |
//! |---|---|---|
//! | [`Method::Algebraic`] | `sum abs(R_i x + t_i - c)^2` | yes |
//! | [`Method::TwoStep`] | the same of differences of poses, then the pivot | yes |
//! | [`Method::Sphere`] | distances of the marker's origins from a sphere | by their noise, and much |
//! | [`Method::Robust`] | as algebraic, with weights that forget slipped poses | yes |
//! | [`Method::ErrorsInVariables`] | the likelihood of translations and rotations, with such weights | none to first order |
//!
//! Noise of the rotations pulls the tip of the biased methods towards the marker, by about the ratio of its variance to
//! that of the motion, and more poses do not help: at a cone of 5 degrees and 0.2 degrees of noise, 1 mm of 160.
//!
//! [`calibrate_each`] is errors-in-variables for poses that bring a covariance each, as those of a marker that is seen
//! farther away and from other sides while it moves.
//!
//! [`apart`] says whether the methods agree to within their errors: poses that slipped, a divot that gives way or a noise of the rotations
//! that is not what was assumed draws each another way.
//!
//! Refused by name: fewer than three poses, poses without rotation or turned about one axis only, cones below
//! [`LEAST_CONE_DEG`] or hardly more than the noise of the rotations, poses of which less than a half agree: [`Refused`].

mod agree;
mod calibrate;
mod each;
mod error;
mod linear;
mod method;
mod noise;
mod result;
mod robust;
mod statistics;
mod step;

pub use agree::{Apart, apart};
pub use calibrate::{calibrate, calibrate_each};
pub use error::Refused;
pub use method::{Method, Options};
pub use noise::PoseNoise;
pub use result::Pivot;

/// The least half opening of the cone of poses, degrees; see [`crate::coverage::Coverage::cone_rad`].
pub const LEAST_CONE_DEG: f64 = 2.0;
