//! Floor 3: records the session's topics to MCAP, and makes unfinished or damaged recordings readable again.
//!
//! * [`write`](mod@write): bus to file; every pose, bit for bit, and the scene and facts of the run beside it. What a killed recorder left
//!   behind becomes a whole file of its own.
//! * [`read`]: from files, whole or not; built on one tolerant reader, [`read::scan`].
//! * [`edit`]: from files to files.
//! * [`replay`]: from a file back onto the bus.
//! * [`report`](mod@report): from a file to one page that says what was done.
//! * `serve`: a run, live in Foxglove (feature `foxglove`).
//! * [`wire`]: what is in the file, so that other programs can read it.
//!
//! While it grows, a recording is named `FILE.mcap.recording`; only a finished one is named `FILE.mcap`.

pub mod cli;
pub mod edit;
pub mod read;
pub mod replay;
pub mod report;
#[cfg(feature = "foxglove")]
mod serve;
#[cfg(test)]
mod testing;
pub mod wire;
pub mod write;
