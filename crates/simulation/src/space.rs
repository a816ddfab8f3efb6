//! Solids in three dimensions: organs whose shape a label map gives, pushed by a rigid tube.
//!
//! The parts are those of the plane ([`crate::solid`], [`crate::constraint`]) and share its [`crate::control`] and
//! [`crate::sparse`]. Lengths in mm, stresses in any unit `U`: forces are then in `U mm^2`.

pub mod cells;
pub mod element;
pub mod lanes;
pub mod law;
pub mod solid;
pub mod system;
pub mod term;
