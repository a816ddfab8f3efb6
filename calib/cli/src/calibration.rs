//! Calibrations on disk: JSON that says what it is, what it rests on and how good it is.

mod bodies;
mod file;
mod parts;
mod read;

pub use bodies::{
    BaseRecord, EmitterRecord, FeatureRecord, GroupRecord, MarkerRecord, RejectedSighting, RejectedTouchRecord,
    SeatDrawing, SeatRecord,
};
pub(crate) use bus::clock::date::now;
pub use file::{CalibrationFile, Kind};
pub(crate) use parts::EMITTERS;
pub use parts::{
    CoverageRecord, Gate, ImportedRecord, PivotRecord, PoseNoiseRecord, PrincipalRecord, Recorded, SpinRecord,
    ToolRecord,
};
pub use read::CalibrationError;

/// The value of `trocar_calibration`. It rises when a key changes its meaning or goes; new keys leave it.
pub const CALIBRATION_VERSION: u32 = 1;
