//! `[tracker.room.probe.tank]`: a water tank with a phantom of wires, which the simulated probe images instead of the patient.
//!
//! The reference marker stands at the tank, and the phantom stands where its file tells of it in that marker, but for the errors
//! that the scene plants. The room's frame (the CT's) is where the tank stands still.

use std::path::PathBuf;

use geometry::{Direction, Phantom, Point};
use serde::{Deserialize, Serialize};

use super::Deviations;

/// The tank, checked; its file is read by whoever images it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tank {
    /// A device set of PLUS with the phantom's wires and its place, `Phantom` to `Reference`.
    pub file: PathBuf,
    /// The water's temperature; `None`: sound goes in it as `[tracker.room.probe]` says.
    pub water_celsius: Option<f64>,
    /// By how much the phantom stands elsewhere than its file tells, about the middle of its wires.
    pub error: Deviations,
    /// A flat bottom that lets no sound through; `None`: the water has no end.
    pub bottom: Option<Bottom>,
}

/// The flat bottom of a tank, in the frame of its phantom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bottom {
    /// A place on it.
    pub point: Point<Phantom>,
    /// Square to it.
    pub normal: Direction<Phantom>,
}

/// `[tracker.room.probe.tank]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawTank {
    /// A device set of PLUS with the phantom's wires and where it stands in the reference marker; relative to the scene file.
    pub file: String,
    /// The water's temperature, degrees Celsius; absent: sound goes in it as `speed_percent` says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub water_celsius: Option<f64>,
    /// Error of the phantom's place: standard deviation along each axis, mm.
    pub error_mm: f64,
    /// And of its turn about each axis through the middle of its wires, degrees.
    pub error_deg: f64,
    /// The flat bottom; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bottom: Option<RawBottom>,
}

/// `bottom` of `[tracker.room.probe.tank]`
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawBottom {
    /// A place on it in the phantom's frame, mm.
    pub point_mm: [f64; 3],
    /// A direction square to it in the phantom's frame, of any length.
    pub normal: [f64; 3],
}

#[cfg(test)]
mod tests;
