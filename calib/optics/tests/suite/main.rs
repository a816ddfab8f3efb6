//! Discs, grids and cameras in drawn images.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod camera;
#[path = "../common/mod.rs"]
mod common;
mod disc;
mod grid;
mod grid_lens;
mod grid_planted;
