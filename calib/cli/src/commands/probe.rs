//! `calib probe` and `calib lag`: points of a phantom's wires in tracked ultrasound images to the image's place in the probe's
//! marker, and how late its poses are.

mod args;
mod array;
mod beams;
mod error;
mod file;
mod images;
mod input;
mod lag;
mod phantom;
mod report;
mod seeing;
mod segment;
mod sheet;
#[cfg(test)]
mod tests;
mod water;

pub(crate) use args::{PROBE_HELP, ProbeArgs};
pub use array::ArrayRecord;
pub(crate) use beams::{ArrayArgs, frames};
pub(crate) use error::ProbeCommandError;
pub use file::{
    CrossRecord, LagRecord, MovedRecord, PROBE_FORMAT, PROBE_VERSION, ProbeFile, ProbeReadError, ProbeSource,
};
pub use images::ImagesRecord;
pub(crate) use lag::{LAG_HELP, LagArgs};
pub(crate) use segment::TOLD_EVERY;
pub(crate) use sheet::Sheet;
pub use water::WaterRecord;
pub(crate) use water::celsius_of;
