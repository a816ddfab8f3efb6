//! Floor 1: from measured points to calibrations and registrations, each with the error it reached.
//!
//! Pure numerics: no file, no clock, no process. Lengths are in millimetres, angles in radians, frames are types.
//! Chapter 4 of part III of the thesis is [`registration`]; the question it ends on, which shape is best for a marker,
//! is [`marker`]. [`pose`] is what a tracker computes for each sample. Of the calibrations of part I, [`bundle`] finds a
//! marker's emitters, [`pivot`] the tip of an instrument, [`spin`] its shaft, [`base`] the tool in its seat on the
//! calibration base; [`f2554`] says how well a pointer locates points, [`coverage`] whether the recorded motion was enough,
//! and [`gate`] whether a result is good enough.
//! [`file`](mod@file) reads the results back, from their text.
//! Two neighbours stand in folders of their own: `bead`, metal beads in a CT, and `optics`, targets in images and cameras.

pub mod base;
pub mod bundle;
pub mod coverage;
pub mod f2554;
pub mod file;
pub mod gate;
pub mod marker;
pub mod motion;
pub mod pivot;
pub mod pose;
pub mod registration;
pub mod spin;
