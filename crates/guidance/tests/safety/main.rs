//! The safety distance, held against ways that share nothing with it: every voxel by force, closed forms, SciPy.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]
#![allow(clippy::print_stdout, reason = "why a test is skipped, and what an oracle found")]

mod brute;
mod cases;
mod forms;
mod motion;
mod refusals;
mod scipy;
mod support;
