//! Calibrations of a probe: recorded by others, and planted.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(
    clippy::print_stdout,
    reason = "a test that is skipped says why, and others what they measured"
)]

mod lag;
mod planted;
mod plus;
