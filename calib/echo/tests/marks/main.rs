//! Dots, wires and walls in generated images.
#![allow(clippy::unwrap_used, reason = "a test that fails says where")]

mod made;
mod wall;
mod wires;
