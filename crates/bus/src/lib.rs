//! Floor 2: what the processes share and nothing else. Messages, topics, the clock, the run's folder.
//!
//! This is the only crate that names iceoryx2. Everybody else sees [`Bus`] and the ports it hands out.
//!
//! * [`message`]: plain `repr(C)` structs with versioned type names; numbers only.
//! * [`topic`]: the one table of topics.
//! * [`Bus`], [`port`]: publishers, subscribers, the shared volume, requests and replies.
//! * [`volume`]: how voxels lie in shared memory, and reading them in place.
//! * [`clock`]: one monotonic clock per run, in nanoseconds, fakeable.
//! * [`session`]: the clock by which poses and images are old: the run's, that of a replay, or simulated time.
//! * [`life`]: signs of life of a process that is not on the bus yet.
//! * [`lockstep`]: at full speed, waiting until every view has drawn a pose before the next goes out.
//! * [`run`]: the folder, the lock and the left-overs of a run.

pub mod clock;
pub mod continuity;
pub mod gather;
pub mod life;
pub mod lockstep;
pub mod message;
mod node;
pub mod port;
pub mod process;
pub mod run;
pub mod session;
pub mod topic;
mod unfinished;
pub mod volume;
pub mod wake;

pub use node::{Bus, BusError};
