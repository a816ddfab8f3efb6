//! The combined API and its sessions, from outside.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(clippy::print_stdout, reason = "why a test is skipped")]

mod answers;
mod client;
mod commands;
mod damage;
mod frames;
mod kept_replies;
mod malformed_bx2;
mod malformed_stream;
mod pair;
mod polled;
mod poses;
mod resync;
mod rom;
mod round_trip;
mod status;
mod support;
