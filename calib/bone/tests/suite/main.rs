//! Bone from generated CTs.

#[path = "../common/mod.rs"]
#[allow(dead_code, reason = "the benchmark takes the rest")]
mod common;

mod accuracy;
mod choice;
mod open;
