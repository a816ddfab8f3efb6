//! Two runs of this machine, one shown in the other: real processes, a real bus each, a real link between them.

#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    clippy::unwrap_used,
    missing_docs,
    reason = "tests and benchmarks start programs, measure time and say why they skip"
)]

#[allow(dead_code, reason = "shared with the tests of the link")]
#[path = "../link/support/authority.rs"]
mod authority;
mod both;
#[allow(unreachable_pub, reason = "shared with the tests of the workspace beside this one")]
#[path = "../../../tests/support/cable.rs"]
mod cable;
mod cuts;
mod far;
mod forged;
#[allow(dead_code, reason = "shared with the tests of the link")]
#[path = "../link/support/forger.rs"]
mod forger;
mod gaps;
mod glass;
mod liar;
mod markers;
mod organs;
mod pieces;
mod pilot;
mod recorded;
mod refused;
mod rig;
mod shown;
mod slow;
mod stale;
mod wire;
