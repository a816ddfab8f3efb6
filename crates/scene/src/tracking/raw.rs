//! `[tracker.emitters]`, `[tracker.sequence]`, `[tracker.calibration]`, `[tracker.registration]` and `[tracker.smoothing]` as
//! they are written.

use serde::{Deserialize, Serialize};

use super::super::operating_room::raw::{RawGates, RawMarker, RawReference};
use super::super::raw::RawRigid;

/// `[tracker.emitters]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawEmitterSource {
    /// `[tracker.emitters.marker]`
    pub marker: RawMarker,
    /// `[tracker.emitters.reference]`; absent: no marker on the patient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<RawReference>,
    /// `[tracker.emitters.localizer]`
    pub localizer: RawNoise,
    /// `[tracker.emitters.gates]`
    pub gates: RawGates,
    /// `[tracker.emitters.reference_gates]`
    pub reference_gates: RawGates,
}

/// `[tracker.emitters.localizer]`: the noise that emitters are weighted with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawNoise {
    /// Standard deviation across the line of sight, mm.
    pub across_mm: f64,
    /// Along it, mm.
    pub depth_mm: f64,
    /// The distance for which these hold, mm.
    pub at_mm: f64,
    /// How the deviation across grows: its power of the distance.
    pub growth_across: f64,
    /// How the one along grows.
    pub growth_depth: f64,
    /// Coordinates are rounded to multiples of this, mm; 0: they are not.
    pub quantisation_mm: f64,
}

impl Default for RawNoise {
    fn default() -> Self {
        Self {
            across_mm: 0.1,
            depth_mm: 0.15,
            at_mm: 2300.0,
            growth_across: 1.0,
            growth_depth: 2.0,
            quantisation_mm: 0.0,
        }
    }
}

/// `[tracker.sequence]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSequence {
    /// A sequence of the PLUS toolkit (.mha), relative to the scene file.
    pub file: String,
    /// The transform of the tool's marker, such as `StylusToTracker`; absent: the only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marker: Option<String>,
    /// That of the marker on the patient; absent: the registration rests on a localizer that stands still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Where the marker sits on the tool.
    #[serde(default)]
    pub marker_from_tool: RawRigid,
    /// Where the marker on the patient sits; goes with `reference`.
    #[serde(default)]
    pub ct_from_reference: RawRigid,
    /// Standard deviation of a pose along each axis at the marker, mm; absent: not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_mm: Option<f64>,
    /// And about each axis, degrees.
    #[serde(default)]
    pub noise_deg: f64,
}

/// `[tracker.markers]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawMarkerSource {
    /// What the localizer calls the tool's marker, such as `StylusToTracker`; absent: its only one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marker: Option<String>,
    /// What it calls the marker on the patient; absent: the registration rests on a localizer that stands still.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Where the marker sits on the tool.
    pub marker_from_tool: RawRigid,
    /// Where the marker on the patient sits; goes with `reference`.
    pub ct_from_reference: RawRigid,
    /// Standard deviation of a pose along each axis at the marker, mm; absent: not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_mm: Option<f64>,
    /// And about each axis, degrees.
    pub noise_deg: f64,
    /// A pose whose localizer states a larger error of fit is refused, mm; absent: not tested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_error_mm: Option<f64>,
}

/// `[tracker.calibration]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawCalibrationFile {
    /// A file of `calib`, relative to the scene file.
    pub file: String,
    /// The name of the marker that it must be of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marker: Option<String>,
    /// `[tracker.calibration.gates]`
    #[serde(default)]
    pub gates: RawCalibrationGates,
}

/// `[tracker.calibration.gates]`: when a calibration is refused; a key that is absent is not tested.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawCalibrationGates {
    /// Largest root mean square residual, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_rms_mm: Option<f64>,
    /// Largest root mean square error of the tip by its covariance, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_tip_error_mm: Option<f64>,
    /// Largest condition of the equations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_condition: Option<f64>,
    /// Least half opening of the cone that the motion filled, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_cone_deg: Option<f64>,
}

/// `[tracker.registration]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawRegistrationFile {
    /// A file of `calib`, relative to the scene file.
    pub file: String,
    /// The name of the marker that it must be of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marker: Option<String>,
    /// Take a file that does not say of which CT it is.
    #[serde(default)]
    pub unchecked_ct: bool,
    /// `[tracker.registration.gates]`
    #[serde(default)]
    pub gates: RawRegistrationGates,
}

/// `[tracker.registration.gates]`: when a registration is refused; a key that is absent is not tested.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawRegistrationGates {
    /// Largest root mean square residual of the points, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_fre_mm: Option<f64>,
    /// Largest condition of the points' layout.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_condition: Option<f64>,
    /// Largest error predicted at the target, 95 %, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_tre_mm: Option<f64>,
}

/// `[tracker.smoothing]`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSmoothing {
    /// Time constant, which is the delay of a steady motion, ms.
    pub time_constant_ms: f64,
}
