//! Registration by the surface: closed forms, planted answers, the problems of the oracle, and what must be refused.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(clippy::print_stderr, reason = "a test that is skipped says why")]

#[path = "../common/mod.rs"]
mod common;
#[allow(dead_code, reason = "each of the two users takes what it needs")]
#[path = "../../src/shapes.rs"]
mod shapes;

mod bad_input;
mod border;
mod distances;
mod ends;
mod free;
mod moved;
mod next;
mod oracle;
mod planted;
mod systematic;
mod verdict;
mod weak;
