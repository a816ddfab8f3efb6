//! Registrations and calibrations against planted answers, oracles and refusals.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod base;
mod bundle;
#[path = "../common/mod.rs"]
mod common;
mod f2554;
mod paired_points_oracle;
mod pivot;
mod pivot_apart;
mod pivot_each;
mod pivot_refusals;
mod planted;
mod propagated;
mod refusals;
mod seen;
mod spin;
mod spin_slips;
mod statistics;
