//! The parts of a calibration file. Units are in the names of the keys.

use calib::coverage::Coverage;
use calib::pivot::PoseNoise;
use geometry::Marker;
use serde::{Deserialize, Serialize};

/// The recording that a calibration rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recorded {
    /// As given.
    pub path: String,
    /// Bytes of the header or file, or of all files of a folder.
    pub bytes: u64,
    /// BLAKE3 of the file, or of the names and contents of a folder's files in order, hexadecimal.
    pub source_blake3: String,
    /// The transform of a sequence.
    pub transform: Option<String>,
    /// Frames in it.
    pub frames: usize,
    /// Poses that took part: valid, and no repeat of the one before.
    pub poses: usize,
    /// Frames whose status was not OK.
    pub invalid: usize,
    /// Poses that repeat the one before, left out.
    pub repeated: usize,
    /// Time stamps that went backwards, and that stood still.
    pub backwards: usize,
    /// See `backwards`.
    pub same_time: usize,
    /// The largest distance of a matrix from a rotation, Frobenius norm.
    pub matrix_off: f64,
}

/// Noise of a pose, each part isotropic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseNoiseRecord {
    /// Of the translation, along each axis.
    pub sigma_mm: f64,
    /// Of the rotation, about each axis.
    pub sigma_deg: f64,
}

impl From<PoseNoise> for PoseNoiseRecord {
    fn from(noise: PoseNoise) -> Self {
        Self {
            sigma_mm: noise.sigma_mm,
            sigma_deg: noise.sigma_rad.to_degrees(),
        }
    }
}

/// The motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoverageRecord {
    /// The principal axes, the widest turn first.
    pub principal: Vec<PrincipalRecord>,
    /// What should have been turned more; `null` where nothing.
    pub advice: Option<String>,
}

/// A principal axis of the motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PrincipalRecord {
    /// In the marker.
    pub axis: [f64; 3],
    /// Twice the root mean square turn about it.
    pub angle_deg: f64,
}

impl CoverageRecord {
    pub(crate) fn new(coverage: &Coverage<Marker>, advice: Option<String>) -> Self {
        let principal = coverage.principal.iter().map(|p| PrincipalRecord {
            axis: p.axis.components(),
            angle_deg: p.angle_rad.to_degrees(),
        });
        Self {
            principal: principal.collect(),
            advice,
        }
    }
}

/// A bound that the result had to keep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gate {
    /// The option's name without dashes, for instance `max-rms-mm`.
    pub name: String,
    /// The bound.
    pub limit: f64,
    /// What was found.
    pub found: f64,
    /// Whether it was kept.
    pub kept: bool,
    /// Where it is from, where that is not the command line: `tracker.calibration.gates of` a scene.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub of: Option<String>,
}

impl Gate {
    /// The bound in words: as an option, or as the key of a scene.
    pub(crate) fn words(&self) -> String {
        let limit = self.limit;
        match &self.of {
            None => format!("--{} {limit}", self.name),
            Some(of) => format!("{} {limit} ({of})", self.name.replace('-', "_")),
        }
    }

    /// What was found, in words.
    pub(crate) fn found_words(&self) -> String {
        match self.found.is_finite() {
            true => format!("found {:.4}", self.found),
            false => "not measured".to_owned(),
        }
    }
}

/// What the covariance of a tip or a tool leaves out: the marker's emitters are off the places that poses were solved with, by the error
/// that `calib marker` states, the same in all poses.
pub(crate) const EMITTERS: &str = "taken as exact: the error of their places is not in the covariance";

/// A pivot calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PivotRecord {
    /// As on the command line.
    pub method: String,
    /// The tip in the marker.
    pub tip_mm: [f64; 3],
    /// Where it stayed, in the tracker.
    pub pivot_mm: [f64; 3],
    /// Poses of weight above zero.
    pub inliers: usize,
    /// Root mean square residual of these as lengths: divides by their number.
    pub rms_mm: f64,
    /// The same of the components: divides by three times their number.
    pub rms_scalar_mm: f64,
    /// As `rms_mm`, of all poses.
    pub rms_all_mm: f64,
    /// The longest residual of an inlier.
    pub worst_mm: f64,
    /// Covariance of (tip in the marker, pivot in the tracker), the upper triangle by rows; `null` where the method has
    /// none.
    pub covariance_upper_mm2: Option<[f64; 21]>,
    /// Whether the poses brought their own covariances.
    #[serde(default)]
    pub pose_covariances: bool,
    /// Residuals in units of the noise given, by their median; absent where the method has no weights.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub noise_ratio: Option<f64>,
    /// Condition number of the equations.
    pub condition: f64,
    /// What the weights and the covariance took for the ratio of the noises.
    pub noise_assumed: PoseNoiseRecord,
    /// What the residuals show.
    pub noise_estimated: PoseNoiseRecord,
    /// The motion of the inliers.
    pub coverage: CoverageRecord,
    /// That the marker's emitters are taken as exact, in words; absent in files of before, of which it is true too.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub emitters: Option<String>,
    /// Where the methods disagree by more than their errors: how, in words.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub disagreement: Option<String>,
}

/// A spin calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpinRecord {
    /// The axis in the marker, from the handle to the tip; unit.
    pub axis: [f64; 3],
    /// The point of the axis nearest to the marker's origin.
    pub point_mm: [f64; 3],
    /// Root mean square angle of the axis to its mean direction.
    pub wobble_rms_deg: f64,
    /// Root mean square distance of the point from its mean place, across the axis.
    pub rms_mm: f64,
    /// Poses whose axis counts, and whose place does.
    #[serde(default)]
    pub inliers: usize,
    /// See `inliers`.
    #[serde(default)]
    pub place_inliers: usize,
    /// Range of the turn.
    pub range_deg: f64,
    /// Covariance of the axis, the upper triangle by rows.
    pub axis_covariance_upper_rad2: [f64; 6],
    /// Covariance of the point, the upper triangle by rows.
    pub point_covariance_upper_mm2: [f64; 6],
    /// Error of the axis per error of the mean direction.
    pub condition: f64,
    /// The motion.
    pub coverage: CoverageRecord,
}

/// A tool's frame in its marker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ToolRecord {
    /// `marker_from_tool`: unit quaternion w, x, y, z. Origin at the tip, +z from the handle to the tip.
    pub quaternion_wxyz: [f64; 4],
    /// Its translation: the tip in the marker.
    pub translation_mm: [f64; 3],
    /// Covariance of (rotation vector in rad, translation in mm) in the marker, turning about its origin, the upper
    /// triangle by rows; the roll about z is taken as exact.
    pub covariance_upper: [f64; 21],
    /// The axis of the marker that the tool's x axis is nearest to.
    pub roll_by: String,
    /// Distance of the tip from the axis found by spinning.
    pub tip_off_axis_mm: f64,
}

/// Where a tool's frame of another program is from, and the error that a person said it has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImportedRecord {
    /// The file.
    pub path: String,
    /// BLAKE3 of its bytes, hexadecimal.
    pub source_blake3: String,
    /// Which of its transforms, and what it was said to map.
    pub transform: String,
    /// The number that the file calls its error; it has no unit and was not used.
    pub source_error: Option<f64>,
    /// Frobenius distance of the file's matrix from the rotation that was taken for it.
    pub matrix_off: f64,
    /// Root mean square error of the tip that a person said: nothing here measured it.
    pub said_tip_error_mm: f64,
    /// The same of the shaft's direction.
    pub said_axis_error_deg: f64,
}
