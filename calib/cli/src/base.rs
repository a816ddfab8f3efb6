//! `calib base` and `calib seat`: touches on the calibration base to its place, and the tool in its seat to its frame.

mod args;
mod drawing;
mod report;
mod seat;
mod touches;

pub(crate) use args::{BASE_HELP, BaseArgs};
pub(crate) use drawing::Drawn;
pub(crate) use seat::{SEAT_HELP, SeatArgs};
