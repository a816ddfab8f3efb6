//! Floor 1: what a surgeon is told, and when she may be told it. Pure functions; no input or output, no clock.
//!
//! * [`plan`]: what is aimed at, the way there, and what speaks against it in the examination.
//! * [`safety`]: how far a tube stays from each structure of a label map, and where that was not checked.
//! * [`sight`](mod@sight): where a chosen target lies about the tool's axis, how far there is to go, how large the error is that the
//!   pose's covariance predicts there, and a verdict that never claims more than that error allows.
//! * [`workflow`]: the way from an empty run to navigation, with its gates, as a table; and what may be done at each stage of it.
//!
//! Lengths are millimetres, angles radians, times nanoseconds, patient axes LPS.

pub mod plan;
pub mod safety;
pub mod sight;
pub mod workflow;
