//! Two runs of this machine, one shown in the other: real processes, a real bus each, a real link between them.

#[allow(unreachable_pub, reason = "shared with the tests of the workspace beside this one")]
#[path = "../../../tests/support/cable.rs"]
mod cable;
mod cuts;
mod pilot;
mod refused;
mod rig;
mod shown;
