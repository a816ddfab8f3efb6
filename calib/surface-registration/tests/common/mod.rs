//! The bones and problems of `shared/oracles/surface`, and points drawn on their surface with a truth.

#![allow(dead_code, reason = "each user takes what it needs")]
#![allow(clippy::print_stderr, reason = "what is skipped says why")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

pub(crate) mod change;
pub(crate) mod draw;
pub(crate) mod end;
pub(crate) mod oracle;
pub(crate) mod scene;
