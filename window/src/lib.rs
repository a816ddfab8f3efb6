//! The operator's screen: images of one pose, the sight, and what they rest on, read off the bus and painted.
//!
//! [`model`] is what is to be shown, made of messages; [`screen`] lays it out and turns it into shapes; a painter turns these into
//! pixels. Neither knows a bus, a clock or a display, so that every state of the screen is made, painted and read in tests.

pub mod cli;
pub mod code;
pub mod colours;
pub mod display;
pub mod feed;
pub mod frame;
pub mod look;
pub mod model;
pub mod paint;
mod planning;
pub mod ports;
mod program;
mod run;
pub mod screen;
pub mod sizes;
pub mod watch;
pub mod wishes;
