//! Whole studies.

mod accuracy;
mod refused;
mod resumed;
mod support;
