//! The link between two machines, with real sessions over loopback.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, outside of test functions"
)]

mod carries;
mod forged;
mod keys;
mod names;
mod peers;
mod probed;
mod python;
mod quiet;
mod support;
