//! The tracker process: from a source of measurements to `ct_from_tool`, published with its status.
//!
//! Sources are simulated ([`Simulated`], [`operating_room`]), the emitters that another program publishes, or recorded poses of
//! markers. What is simulated is a pure function of the sample's number, so that a restarted process goes on where the
//! script is, and the same seed gives the same poses.

pub mod chain;
pub mod cli;
mod errors;
mod follow;
mod following;
mod gesture;
mod markers;
pub mod operating_room;
mod output;
mod posed_markers;
pub mod probe;
mod run;
mod run_error;
mod simulated;
mod simulated_time;

pub use follow::{FiledError, PlayError, chain_of_files};
pub use following::Following;
pub use gesture::{Gesture, GestureError};
pub use markers::{Markers, MarkersError, Seen};
pub use posed_markers::PosedMarkers;
pub use run_error::RunError;
pub use simulated::{Measured, Simulated};
