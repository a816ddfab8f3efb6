//! `calib f2554`: how well a pointer locates points, measured or simulated.

mod args;
mod chart;
mod data;
mod report;

pub(crate) use args::{F2554_HELP, F2554Args};
