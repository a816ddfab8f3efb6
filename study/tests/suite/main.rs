//! Whole studies.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

mod accuracy;
mod breathing;
mod display;
mod extremes;
mod losses;
mod refused;
mod resumed;
mod support;
mod surface;
mod sweep;
mod tissue;
mod worst;
