//! Recordings: replayed, made again, refused, and read by the software of others.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod before_choices;
mod frozen;
mod mcap_conformance;
mod mcap_groups;
mod missing_frames;
mod replay;
mod replay_bytes;
mod replay_control;
mod replay_ends;
mod replay_recompute;
mod replay_refused;
mod session_report;
#[path = "../support/mod.rs"]
mod support;
mod surface;
mod tissue;
