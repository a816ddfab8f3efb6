//! Drawn images with a planted answer, the same in every run.

#![allow(dead_code, reason = "each test program uses a part")]
#![allow(unused_imports, reason = "each test program uses a part")]

pub(crate) mod grid_series;
pub(crate) mod lens_scene;
#[path = "../../../tests/common/random.rs"]
mod random;

pub(crate) use random::{Random, turn};
