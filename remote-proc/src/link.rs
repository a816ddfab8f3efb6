//! The link between the two machines: its keys, its endpoints, the configuration of both zenoh sessions, and a look at the peer
//! before a session is opened. Nothing here knows what the messages mean.
//!
//! What it holds: data go from the sender to its receivers and never back, neither to the sender nor through it to another receiver;
//! off loopback both ends show a certificate of one private authority; a receiver that stops reading, or goes on declaring, holds up
//! nobody else for long.

pub mod config;
pub mod endpoint;
pub mod keys;
pub mod probe;
pub mod watch;
