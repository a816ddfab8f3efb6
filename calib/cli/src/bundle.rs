//! `calib marker`: frames of a localizer to the places of a marker's emitters.

mod args;
mod drawing;
mod frames;
mod refusal;
mod report;
mod scene;

pub(crate) use args::{MARKER_HELP, MarkerArgs};
pub(crate) use frames::covariance;
pub(crate) use scene::table;
