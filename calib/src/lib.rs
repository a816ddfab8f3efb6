//! Floor 1: from measured points to calibrations and registrations, each with the error it reached.
//!
//! Pure numerics: no file, no clock, no process. Lengths are in millimetres, angles in radians, frames are types.
//! Chapter 4 of part III of the thesis is [`registration`]; the question it ends on, which shape is best for a marker,
//! is [`marker`]. [`pose`] is what a tracker computes for each sample. Of the calibrations of part I, [`pivot`] finds the
//! tip of an instrument, [`spin`] its shaft, and [`coverage`] says whether the recorded motion was enough for either.

pub mod coverage;
pub mod marker;
pub mod pivot;
pub mod pose;
pub mod registration;
pub mod spin;
