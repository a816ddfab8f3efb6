//! Floor 2: a tracked ultrasound probe: where its image lies in its marker, how late it is, and bone in it.
//!
//! Pure numerics: no file, no clock, no process. Lengths are mm, angles rad, frames are types. The same input gives
//! the same bits.
//!
//! | step | where |
//! |---|---|
//! | wires of a phantom, checked | [`Wires`] |
//! | points of wires in tracked images to the place of the image in the marker, with covariance | [`calibrate`] |
//! | the same from a flat wall whose place is not known | [`calibrate_by_wall`] |
//! | how far points of images that took no part lie from their wires | [`check`](fn@check), [`cross_validate`] |
//! | motions that the frames do not hold, in words | [`ProbeCalibration::free`] |
//! | how late poses are, from one motion that images and poses show | [`lag`](fn@lag) |
//! | poses between those recorded, or a mean of neighbours | [`Track`] |
//!
//! A pixel `(u, v)` of the image (whole numbers are centres of pixels, u to the right, v down) with sizes `(s_u,
//! s_v)` lies in the
//! probe's marker at
//!
//! ```text
//! p = R (u s_u, v s_v, 0) + t                                                                                    (1)
//! ```
//!
//! so that the frame [`geometry::Image`] is here in mm from the centre of the first pixel: x right, y down, z = x x
//! y. An image that is
//! shown mirrored has a place in space like any other, with z on the other side; what is wrong is to show it one way
//! when calibrating
//! and another way later.

mod calibration;
mod check;
mod error;
mod free;
mod known;
mod lag;
mod linear;
mod seen;
mod solve;
mod target;
mod track;

pub use calibration::{Lag, Moved, PointResult, ProbeCalibration, calibrate, calibrate_by_wall};
pub use check::{Checked, CrossValidated, check, cross_validate};
pub use error::ProbeError;
pub use free::Free;
pub use known::KnownImage;
pub use lag::{LagError, LagOptions, MotionLag, lag, principal_motion};
pub use seen::{LEAST_FRAMES, MOST_POINTS, Mark, Seen};
pub use solve::{Options, PointNoise, PoseNoise, Priors};
pub use target::{Wire, Wires};
pub use track::{Track, TrackError};
