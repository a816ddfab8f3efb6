//! Bone from generated CTs.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

#[path = "../common/mod.rs"]
#[allow(dead_code, reason = "the benchmark takes the rest")]
mod common;

mod accuracy;
mod choice;
mod open;
mod vessel;
