//! Floor 3: `calib`, the command line of the calibrations: files in, a report on stdout and a file of the result out.
//!
//! The numerics are in the crate `calib`; here are the files, the words and the errors. Lengths in files and on the
//! command line are millimetres, angles degrees where a person reads them (`_deg`, "deg") and radians in
//! [`RegistrationFile`].

mod base;
mod beads;
mod bone;
mod bounds;
mod bundle;
mod calibration;
mod camera;
pub mod cli;
mod commands;
mod f2554;
mod foreign;
mod grid;
mod input_files;
mod live;
mod poses;
mod refusal;
mod register;
mod rom;
mod scene_context;
mod steps;
mod store;
mod surface;
mod text;
mod values;

pub use beads::{
    BEADS_FORMAT, BEADS_VERSION, BeadRecord, BeadsFile, LoadLabels, LoadVolume, Loaded, ReadLabelNames, RejectedRecord,
    SearchRecord, VolumeRecord,
};
pub use bone::{BONE_FORMAT, BONE_VERSION, BoneFile, BoneScannerRecord, LostRecord};
pub use calibration::{
    BaseRecord, CALIBRATION_VERSION, CalibrationError, CalibrationFile, CoverageRecord, EmitterRecord, FeatureRecord,
    Gate, GroupRecord, ImportedRecord, Kind, MarkerRecord, PivotRecord, PoseNoiseRecord, PrincipalRecord, Recorded,
    RejectedSighting, RejectedTouchRecord, SeatDrawing, SeatRecord, SpinRecord, ToolRecord,
};
pub use camera::{
    CAMERA_FORMAT, CAMERA_VERSION, CameraFile, CameraReadError, CameraView, FieldRecord, PlateRecord, SourceRecord,
};
pub use commands::probe::{
    ArrayRecord, CrossRecord, ImagesRecord, LagRecord, MovedRecord, PROBE_FORMAT, PROBE_VERSION, ProbeFile,
    ProbeReadError, ProbeSource, WaterRecord,
};
pub use grid::{ReadImageError, read_image};
pub use live::{Delivered, Follow, FollowMarkers, HeardPoses, OfflineError, Seen};
pub use register::file::{
    Certificate, FORMAT, InputFile, Noise, PairResult, PredictedTre, ReadError, RegistrationFile, TouchNoise,
    Transform, Units, VERSION,
};
pub use steps::hand as practice;
pub use surface::REFUSED_FORMAT;
