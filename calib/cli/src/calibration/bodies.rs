//! The parts of a calibration file that describe bodies: a marker's emitters, the base, the tool in its seat. Units are in
//! the names of the keys.

use serde::{Deserialize, Serialize};

/// A marker: its emitters in its own frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MarkerRecord {
    /// By their number; `null` for one that was seen too seldom.
    pub emitters: Vec<Option<EmitterRecord>>,
    /// What fixes the frame: `principal axes`, or the file whose frame it has.
    pub frame: String,
    /// Views that gave a pose; 0 where the emitters were read from a drawing.
    pub views: usize,
    /// Root mean square length of all residuals; `null` from a drawing, like those below.
    pub rms_mm: Option<f64>,
    /// Residuals in units of the noise given.
    pub noise_ratio: Option<f64>,
    /// Standard deviation per axis that explains the residuals.
    pub sigma_mm: Option<f64>,
    /// Ratio of the largest deviation of any combination of places to the least.
    pub condition: Option<f64>,
    /// Root mean square error of the places to be expected, with the noise given.
    pub predicted_rms_mm: Option<f64>,
    /// Sightings that were left out.
    pub rejected: Vec<RejectedSighting>,
}

/// An emitter of a marker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EmitterRecord {
    /// In the marker.
    pub at_mm: [f64; 3],
    /// The way it looks, unit; absent where it is not known.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub normal: Option<[f64; 3]>,
    /// Covariance of the place with the noise given, the upper triangle by rows; absent where it is not known.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub covariance_upper_mm2: Option<[f64; 6]>,
    /// Sightings that took part.
    pub sightings: usize,
    /// Root mean square length of their residuals.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub rms_mm: Option<f64>,
    /// The longest.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub worst_mm: Option<f64>,
}

/// A sighting that was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RejectedSighting {
    /// The frame's number in the recording.
    pub frame: usize,
    /// The emitter's.
    pub emitter: usize,
    /// Its distance from where the others put it; `null` where its frame has no pose without it.
    pub residual_mm: Option<f64>,
}

/// Where the calibration base was, and the seat of the tool in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BaseRecord {
    /// The frame of the touches: `tracker`, or `reference` for a marker on the base.
    pub of_frame: String,
    /// `frame_from_base`: unit quaternion w, x, y, z.
    pub quaternion_wxyz: [f64; 4],
    /// Its translation.
    pub translation_mm: [f64; 3],
    /// Covariance of (rotation vector in rad, translation in mm) in that frame, turning about its origin, the upper triangle
    /// by rows.
    pub covariance_upper: [f64; 21],
    /// The groups of touches and what each lies on.
    pub groups: Vec<GroupRecord>,
    /// The plane and the three grooves.
    pub features: Vec<FeatureRecord>,
    /// Touches that were left out.
    pub rejected: Vec<RejectedTouchRecord>,
    /// Root mean square distance of the touches kept.
    pub rms_mm: f64,
    /// Residuals in units of the noise given.
    pub noise_ratio: f64,
    /// Ratio of the largest deviation of any motion of the base to the least.
    pub condition: f64,
    /// The motion of the largest deviation, in words.
    pub weakest: String,
    /// Radius of the tip's ball.
    pub tip_radius_mm: f64,
    /// Where the tool sits, as drawn.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub base_from_tool: Option<SeatDrawing>,
}

/// A group of touches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupRecord {
    /// Its name in the recording.
    pub name: String,
    /// `plane` or `groove 0` to `groove 2`.
    pub feature: String,
    /// Touches in it.
    pub touches: usize,
}

/// The residuals on a feature of the base.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FeatureRecord {
    /// `plane` or `groove 0` to `groove 2`.
    pub feature: String,
    /// Touches that took part.
    pub touches: usize,
    /// Root mean square distance.
    pub rms_mm: f64,
    /// The largest distance.
    pub worst_mm: f64,
}

/// A touch that was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RejectedTouchRecord {
    /// Its line in the recording.
    pub line: usize,
    /// Its distance from the feature.
    pub distance_mm: f64,
}

/// The seat of the tool in the base.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeatDrawing {
    /// `base_from_tool`: unit quaternion w, x, y, z.
    pub quaternion_wxyz: [f64; 4],
    /// Its translation: the tip in the base.
    pub translation_mm: [f64; 3],
    /// Covariance of (rotation vector in rad, translation in mm) in the base, turning about its origin, the upper triangle by
    /// rows.
    pub covariance_upper: [f64; 21],
}

/// How the tool's frame followed from its seat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeatRecord {
    /// Frames that show the tool in its seat.
    pub frames: usize,
    /// Their scatter in units of their covariances; `null` for a single frame.
    pub noise_ratio: Option<f64>,
    /// The frame furthest from the mean, deviations.
    pub worst_deviations: f64,
    /// Root mean square distance of the tip at single frames from where the mean has it.
    #[serde(default)]
    pub rms_mm: f64,
    /// Ratio of the largest deviation of any motion of the marker in the frames' mean to the least.
    #[serde(default)]
    pub condition: f64,
    /// That the marker's emitters are taken as exact, in words; absent in files of before, of which it is true too.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub emitters: Option<String>,
}
