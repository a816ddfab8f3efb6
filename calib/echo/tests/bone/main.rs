//! The line of a bone: in generated images with a truth, in images without bone, and in a recording.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::needless_range_loop,
    clippy::too_many_arguments,
    reason = "a test may stop, and tells what it measured; formulas by their indices"
)]

mod generated;
mod nothing;
mod recorded;
mod scan;
