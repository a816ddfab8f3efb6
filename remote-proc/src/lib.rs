//! A run on a second machine: its examination once, its poses as they come, its clock with how well it is known. One way: nothing
//! that comes from outside reaches the bus of the machine that navigates.
//!
//! zenoh carries it, and this crate alone names it: its three hundred crates of others would double every build of the workspace, so
//! it is one of its own, beside it.

pub mod cli;
pub mod facts;
mod linger;
pub mod link;
pub mod protocol;
pub mod receive;
pub mod send;
pub mod session;
mod sockets;
