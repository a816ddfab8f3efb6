//! The bones and problems of `shared/oracles/surface`, and points drawn on their surface with a truth.

#![allow(dead_code, reason = "each user takes what it needs")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

pub mod draw;
pub mod oracle;
