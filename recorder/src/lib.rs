//! Floor 3: records the session's topics to MCAP, and makes unfinished or damaged recordings readable again.
//!
//! * [`record`]: bus to file; every pose, bit for bit, and the scene and facts of the run beside it.
//! * [`session_file`], [`pose_log`]: one file of a session; what it says is on disk is on disk.
//! * [`leftovers`]: what a killed recorder left behind becomes a whole file of its own.
//! * [`recover`], [`info`], [`reader`]: from files, whole or not; built on one tolerant reader, [`scan`].
//! * [`replay`]: from a file back onto the bus; [`compare`]: the poses of two files side by side.
//! * [`proto`], [`descriptor`], [`schema`]: what is in the file, so that other programs can read it.
//!
//! While it grows, a recording is named `FILE.mcap.recording`; only a finished one is named `FILE.mcap`.

pub mod attach;
pub mod beside;
pub mod chunk;
pub mod cli;
pub mod compare;
pub mod cut;
pub mod damage;
pub mod descriptor;
pub mod export;
pub mod file_error;
mod file_records;
pub mod import;
pub mod info;
pub mod leftovers;
pub mod lost;
pub mod paths;
pub mod pose_log;
pub mod progress;
pub mod proto;
pub mod reader;
pub mod record;
pub mod recover;
pub mod replay;
pub mod scan;
pub mod schema;
pub mod seek;
pub mod seq;
mod series;
pub mod session_file;
pub mod sink;
pub mod spread;
mod syncer;
pub mod tally;
#[cfg(test)]
mod testing;
pub mod timing;
pub mod verify;
