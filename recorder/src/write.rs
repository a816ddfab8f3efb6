//! From the bus to files; what is said to be on the disk is on the disk.

pub(crate) mod beside;
pub mod file_error;
pub(crate) mod leftovers;
pub mod paths;
pub mod pose_log;
pub(crate) mod record;
pub(crate) mod scene_text;
pub(crate) mod series;
pub mod session_file;
pub(crate) mod sink;
pub(crate) mod syncer;
