//! What the file of a registration says where it was made by the bone's surface.

use serde::{Deserialize, Serialize};

/// Beside the pose: the bone, the numbers that were fitted with it, and what was looked at before it was accepted. Lengths in mm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurfaceRecord {
    /// The bone.
    pub bone: BoneRecord,
    /// What the search began from: `guess`, `landmarks` or `nothing`.
    pub start: String,
    /// By what share depths are too long, and its deviation; the prior's deviation, 0 where it is held.
    pub depth_scale: Fitted,
    /// By how much the true bone lies outside of the surface, likewise.
    pub offset_mm: Fitted,
    /// Residuals over the noise that was told: 1 where it is right.
    pub noise_ratio: f64,
    /// Share of the points that fit.
    pub share_kept: f64,
    /// How many that is, such as were taken by a tool held still as one.
    pub kept: f64,
    /// Share of the points whose beam comes from inside the bone.
    pub share_facing_away: f64,
    /// Share of the points whose nearest place is an open border of the surface.
    pub share_beyond: f64,
    /// Poses that were tried, fits from the best of them, and fits that ended at the result.
    pub searched: [usize; 3],
    /// The other minima that were found, the nearest in cost first.
    pub others: Vec<OtherMinimum>,
    /// Mean square of the landmarks' misses over what their errors say.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub landmark_ratio: Option<f64>,
    /// What is said of the error that all points share.
    pub shared_error: String,
    /// Motions of the patient that the points hold least, in words, with what a deviation of each does at the targets, mm.
    pub free: Vec<FreeMotion>,
    /// Whether it was looked whether the bone moved while points were taken; files of before it was written have none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub moved_check: Option<MovedCheck>,
    /// What residuals go with, beside the noise; files of before it was looked at have none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub trends: Option<TrendsRecord>,
    /// What is not against it, and should be known.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub warnings: Vec<String>,
    /// Each point in the order of the file.
    pub points: Vec<SurfacePointResult>,
}

/// What residuals go with, and what was told of it before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrendsRecord {
    /// The order of the points: a bone that drifted.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub drift: Option<TrendRecord>,
    /// A side whose points lie further outside of the bone than the others.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub side: Option<TrendRecord>,
    /// Deviation that was told of what lies on one side, mm: it is in the covariance.
    pub told_side_mm: f64,
}

/// One of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TrendRecord {
    /// How unlikely it is by chance alone, as deviations of a normal number.
    pub deviations: f64,
    /// How large it is, mm.
    pub mm: f64,
    /// Where to, in `to`.
    pub towards: [f64; 3],
}

/// Whether it was looked whether the bone moved under its marker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MovedCheck {
    /// Whether it could be looked.
    pub made: bool,
    /// At how many places in the order of the points.
    pub places: usize,
    /// Why not, in words.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub why_not: Option<String>,
}

/// The surface that points were registered to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoneRecord {
    /// Triangles in use.
    pub triangles: usize,
    /// Parts inside of others, which were left out.
    pub inner_parts: usize,
    /// Where it is open: its ends, and their length.
    pub open_ends: usize,
    /// mm.
    pub open_length_mm: f64,
    /// Deviation of the surface from place to place that was reckoned with, mm.
    pub sigma_mm: f64,
}

/// A number that was fitted beside the pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fitted {
    /// What was found.
    pub value: f64,
    /// Its deviation.
    pub sigma: f64,
    /// What was known of it before: the deviation about 0; 0 where it was held at 0.
    pub prior_sigma: f64,
}

/// Another pose that fits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OtherMinimum {
    /// By how much its cost is higher, squares of deviations.
    pub margin: f64,
    /// How far it is off at the points, mm, root mean square.
    pub apart_mm: f64,
    /// Fits of the search that ended there.
    pub hits: usize,
}

/// A motion that the points do not hold well.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FreeMotion {
    /// In words.
    pub motion: String,
    /// Root mean square way of the targets in one deviation of it, mm.
    pub at_targets_mm: f64,
}

/// A point's part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurfacePointResult {
    /// Its line in the file, from 1.
    pub line: usize,
    /// Its label; empty without one.
    #[serde(skip_serializing_if = "String::is_empty", default)]
    pub label: String,
    /// Its place in `to`, mm.
    pub place_mm: [f64; 3],
    /// Signed distance to the bone, outside above 0, mm.
    pub residual_mm: f64,
    /// The same in its own deviations.
    pub deviations: f64,
    /// What it counts, 0 to 1.
    pub weight: f64,
    /// `kept`, `in front`, `behind`, `faces away` or `beyond`.
    pub class: String,
}
