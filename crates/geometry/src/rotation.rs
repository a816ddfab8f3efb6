//! Rotations of the plane, of space and of 4-space, in every representation of the thesis (part III, chapter 2).
//!
//! [`Rotation`] is the pivot in space: a unit quaternion. Everything converts to it and from it:
//!
//! ```
//! use geometry::rotation::{Rotation, RotationVector};
//! let tiny = RotationVector::new([1e-300, 0.0, 2e-300])?;
//! let turn = Rotation::from_vector(tiny);
//! assert_eq!(turn.vector(), tiny);
//! assert_eq!(turn.matrix().rows()[1][0], 2e-300);
//! # Ok::<(), geometry::rotation::RotationError>(())
//! ```
//!
//! Conventions: angles in radians; matrices by rows, acting on columns; quaternions (s, u1, u2, u3) with Hamilton's
//! product; a positive angle turns counter-clockwise seen from the axis' tip. Bounds in the docs are in ulp of the whole
//! result's Euclidean norm (2^-52 times the power of two below it), not of each component: relative also for the tiniest
//! rotations.

mod axis_angle;
mod error;
mod euler;
mod exact;
mod four;
mod general;
mod jacobian;
mod matrix;
mod mean;
mod nearest;
mod nearest4;
mod pair;
mod path;
mod planar;
mod quaternion;
mod series;
mod single;
mod vector;

pub use axis_angle::AxisAngle;
pub use error::RotationError;
pub use euler::{Axis, Euler, EulerAngles, Frames};
pub use four::{InvariantPlane, Rotation4};
pub use general::exp_skew;
pub use matrix::RotationMatrix;
pub use mean::{chordal_mean, geodesic_mean};
pub use nearest::Nearest;
pub use pair::Log4;
pub use planar::Rotation2;
pub use quaternion::Rotation;
pub use vector::RotationVector;

pub(crate) use error::finite;
pub(crate) use matrix::quaternion as nearly_orthonormal;
