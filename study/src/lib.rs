//! Floor 4: the experiment in silico. Does the tube reach the node, and was the predicted error right?
//!
//! A study is a number of operations in strata of equal conditions ([`plan`]). Each operation goes the whole way by the
//! functions that the processes of a run go by, through files on disk that these write and read, in virtual time:
//!
//! ```text
//! image of a CT -> beads found ------------------------------------+
//! emitters' frames -> marker -> tip -> base -> seat (tool.json) -> touches -> match (registration.json) -> check
//!                                          |                                  |
//!                                          +--- scene.toml: the tracker's chain of files ---> the hand, by the sight, to each target
//! ```
//!
//! Or, in the place of beads and touches, the pelvis is taken from the image and seen by a tracked ultrasound probe (`steps::surface`).
//!
//! The truth is the simulator's own; nothing of it goes into what is calibrated, registered or shown. At the end of each
//! approach the true error at the target is held against what the pose's covariance predicted, and told link by link
//! (`truth`). Results are lines of `operations.csv` ([`record`]), a report, and charts ([`report`]).
//!
//! The same study file gives the same lines, byte for byte, whatever the number of threads and however often the program was
//! killed and started anew ([`run`]).

mod approach;
mod breathing;
pub mod cli;
mod folder;
mod images;
mod operation;
mod patient;
pub mod pixels;
pub mod plan;
pub mod record;
pub mod report;
mod room;
pub mod run;
mod sounding;
pub mod statistics;
mod steps;
mod tissue;
mod truth;
pub mod worst;

pub use truth::LINKS;

/// Why something was not done, in words for a person.
type Words = Box<dyn std::error::Error + Send + Sync>;
