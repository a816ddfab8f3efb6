//! The pilot: starts the processes of a scene, watches them, restarts what dies, stops them, and says what happened.
//!
//! [`supervise`] decides, as a pure function of what it is told; `spawn` is its hands; `run` feeds it and keeps the
//! metrics: stamps, poses, frames, memory. The pilot never renders a slice and never touches a localizer.

mod answer;
mod check;
mod child;
pub mod cli;
mod ends;
mod guiding;
mod kept;
mod metrics;
mod output;
mod plan;
mod planning;
mod ports;
mod problems;
mod remote;
mod replay;
mod replay_state;
mod report;
mod resolve;
mod run;
mod shutdown;
mod spawn;
mod state;
mod status;
pub mod supervise;

pub use resolve::scene_of_run;
