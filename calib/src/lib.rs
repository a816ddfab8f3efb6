//! Floor 1: from measured points to calibrations and registrations, each with the error it reached.
//!
//! Pure numerics: no file, no clock, no process. Lengths are in millimetres, angles in radians, frames are types.
//! Chapter 4 of part III of the thesis is [`registration`]; the question it ends on, which shape is best for a marker,
//! is [`marker`]. [`pose`] is what a tracker computes for each sample.

pub mod marker;
pub mod pose;
pub mod registration;
