//! `calib beads`, `calib match` and `calib check`: from a CT to a registration that was checked on the patient.

mod check;
mod check_tip;
mod error;
mod file;
mod find;
mod matching;
mod sheet;
#[cfg(test)]
mod tests;
mod touch_noise;
mod volume;

pub(crate) use check::{CHECK_HELP, CheckArgs, uncertain};
pub(crate) use error::BeadsError;
pub use file::{BEADS_FORMAT, BEADS_VERSION, BeadRecord, BeadsFile, RejectedRecord, SearchRecord, VolumeRecord};
pub(crate) use find::{BEADS_HELP, BeadsArgs};
pub(crate) use matching::{MATCH_HELP, MatchArgs};
pub(crate) use sheet::{sample, tone};
pub use volume::{LoadLabels, LoadVolume, Loaded, ReadLabelNames};
pub(crate) use volume::{ReadArgs, Volume, warned};
