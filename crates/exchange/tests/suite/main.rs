//! Files as other programs write them, and back.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod fcsv;
mod itk;
mod markups;
mod mesh;
mod mirror;
mod plus;
