//! Solids in three dimensions: organs whose shape a label map gives, pushed by a rigid tube.
//!
//! The parts are those of the plane ([`crate::solid`], [`crate::constraint`]) and share its [`crate::control`] and
//! [`crate::sparse`]. Lengths in mm, stresses in any unit `U`: forces are then in `U mm^2`.
//!
//! * [`cells`]: a mesh over a region that a field gives, be it the smoothed label of a label map;
//! * [`element`], [`law`], [`lanes`]: the energy of an element with two derivatives;
//! * [`solid`], [`tube`], [`level_set`]: deformable bodies, the rigid tube, and surfaces of bone and organs;
//! * [`term`]: springs, and contact with the tube, with bone and of organs;
//! * [`system`], [`equilibrium`]: all of it together, and the state in which forces balance;
//! * [`frames`]: states from frame to frame as the tube moves;
//! * [`error`]: how far a state is from the one of smaller cubes.

pub mod bodies;
pub mod cells;
pub mod element;
pub mod equilibrium;
pub mod error;
pub mod frames;
mod gap;
pub mod lanes;
pub mod law;
pub mod level_set;
pub mod solid;
pub mod system;
pub mod term;
mod tree;
pub mod tube;
