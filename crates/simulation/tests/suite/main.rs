//! Solids against closed forms, published results and oracles.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod boundaries;
#[path = "../common/mod.rs"]
mod common;
mod contact;
mod detection;
mod elements;
mod exact;
mod exact_extremes;
mod exact_frames;
mod exact_rings;
mod extremes;
mod law_oracle;
mod manufactured;
mod nearly_incompressible;
mod oracle_cases;
