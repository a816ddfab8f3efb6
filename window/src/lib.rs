//! The operator's screen: images of one pose, the sight, and what they rest on, read off the bus and painted.

pub mod code;
pub mod watch;
