//! The codec and the sessions of OpenIGTLink, from outside.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(clippy::print_stdout, reason = "why a test is skipped")]

mod any_message;
mod believed;
mod client;
mod crc;
mod damage;
mod golden;
mod malformed_body;
mod malformed_header;
mod malformed_image;
mod malformed_surface;
mod round_trip;
mod server;
mod stream;
mod support;
