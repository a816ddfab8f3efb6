//! Floor 0: the geometry every other crate speaks.
//!
//! Lengths are millimetres, angles radians, patient axes LPS: +x to the patient's Left, +y Posterior, +z Superior.
//! Frames are types, so that a transform `a_from_b` composes only with something in frame `b`:
//!
//! ```
//! use geometry::{Ct, Point, Rigid, Tool, checked};
//! let ct_from_tool: Rigid<Ct, Tool> = checked::rigid([1.0, 0.0, 0.0, 0.0], [10.0, 20.0, 30.0], 1e-9)?;
//! let tip_in_tool = Point::<Tool>::new(0.0, 0.0, 0.0);
//! let tip: Point<Ct> = ct_from_tool * tip_in_tool;
//! assert_eq!(tip.mm(), [10.0, 20.0, 30.0]);
//! # Ok::<(), geometry::DoorError>(())
//! ```
//!
//! The same chain with a point of another frame does not compile:
//!
//! ```compile_fail,E0308
//! use geometry::{Ct, Point, Rigid, Tool, checked};
//! let ct_from_tool: Rigid<Ct, Tool> = checked::rigid([1.0, 0.0, 0.0, 0.0], [10.0, 20.0, 30.0], 1e-9)?;
//! let tip_in_tool = Point::<Ct>::new(0.0, 0.0, 0.0);
//! let tip: Point<Ct> = ct_from_tool * tip_in_tool;
//! # Ok::<(), geometry::DoorError>(())
//! ```
//!
//! [`Uncertain`] is a transform together with the covariance of its error, carried along by the same operations.
//!
//! What types cannot catch: *time*. `Rigid<Ct, Tool>` of one sample and of the next have the same type; that they
//! belong together is the business of sequence numbers and stamps, on the bus.

mod affine;
pub mod checked;
mod frame;
mod grid;
mod letters;
pub mod motion;
pub mod named;
mod plane;
mod point;
mod rigid;
pub mod rotation;
pub mod uncertain;

pub use affine::Affine;
pub use checked::DoorError;
pub use frame::{
    Base, Ct, Frame, Image, Marker, Model, Named, Phantom, Pointer, Probe, Reference, Tool, Tracker, Voxel,
};
pub use grid::{GridError, MAX_DIM, MAX_VOXELS, VolumeGrid};
pub use letters::letters;
pub use plane::{PlaneError, Projected, SlicePlane};
pub use point::{Direction, Point, Vector};
pub use rigid::Rigid;
pub use uncertain::{Uncertain, UncertainPoint};
