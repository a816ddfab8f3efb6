//! Floor 1: from measured points to calibrations and registrations, each with the error it reached.
//!
//! Pure numerics: no file, no clock, no process. Lengths are in millimetres, angles in radians, frames are types.
//! Chapter 4 of part III of the thesis is [`registration`]; the question it ends on, which shape is best for a marker,
//! is [`marker`]. [`pose`] is what a tracker computes for each sample. Of the calibrations of part I, [`bundle`] finds a
//! marker's emitters, [`pivot`] the tip of an instrument, [`spin`] its shaft, [`base`] the tool in its seat on the
//! calibration base; [`f2554`] says how well a pointer locates points, [`coverage`] whether the recorded motion was enough,
//! and [`gate`] whether a result is good enough.
//! [`bead`] registers the patient: it finds metal beads in the CT, tells which of them was touched, and judges the check.
//! [`file`](mod@file) reads the results back, from their text.
//! Chapter 5 of part III, targets in images, is [`disc`] and [`grid`], which take a [`mod@image`]; [`camera`] calibrates a
//! camera from views of a grid.

pub mod base;
pub mod bead;
pub mod bundle;
pub mod camera;
pub mod coverage;
pub mod disc;
pub mod f2554;
pub mod file;
pub mod gate;
pub mod grid;
pub mod image;
pub mod marker;
pub mod pivot;
pub mod pose;
pub mod registration;
pub mod spin;
