//! `[tracker.room]` as it is written.

use serde::{Deserialize, Serialize};

use super::super::raw::RawRigid;
use super::tank::RawTank;

/// `[tracker.room]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawRoom {
    /// Error of the tool's calibration: standard deviation of the tip along each axis, mm.
    pub calibration_error_mm: f64,
    /// And of the tool's direction about each axis, degrees.
    pub calibration_error_deg: f64,
    /// Error of the patient's registration: standard deviation of the target along each axis, mm.
    pub registration_error_mm: f64,
    /// And of the turn about each axis through the target, degrees.
    pub registration_error_deg: f64,
    /// `[tracker.room.marker]`
    pub marker: RawMarker,
    /// `[tracker.room.handle]`
    pub handle: RawHandle,
    /// `[tracker.room.hand]`; absent: no hand comes in the way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand: Option<RawHand>,
    /// `[tracker.room.localizer]`
    pub localizer: RawLocalizer,
    /// `[tracker.room.patient]`
    pub patient: RawPatient,
    /// `[tracker.room.reference]`; absent: no marker on the patient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<RawReference>,
    /// `[tracker.room.faults]`
    pub faults: RawFaults,
    /// `[tracker.room.gates]`
    pub gates: RawGates,
    /// `[tracker.room.reference_gates]`
    pub reference_gates: RawGates,
    /// `[tracker.room.gesture]`; absent: that of `[tracker.approach]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gesture: Option<RawGesture>,
    /// `[tracker.room.practice]`; absent: the hand does its gesture and nothing else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub practice: Option<RawPractice>,
    /// `[tracker.room.probe]`; absent: the tool is no ultrasound probe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe: Option<RawProbe>,
}

/// `[tracker.room.probe]`: the tool is an ultrasound probe, its tip the middle of the face; beams run along the tool's z,
/// the image's rows along its x.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawProbe {
    /// The width of a linear array, mm; not beside `radius_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_mm: Option<f64>,
    /// The radius of a curved array's face, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// The angle from the first beam of a curved array to its last, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// How deep beams are shown, mm.
    pub depth_mm: f64,
    /// The side of a pixel, mm.
    pub pixel_mm: f64,
    /// Images a second.
    pub rate_hz: f64,
    /// How much later than its capture an image is stamped, ms.
    pub lag_ms: f64,
    /// How much faster than the scanner assumes sound runs, percent.
    pub speed_percent: f64,
    /// `[tracker.room.probe.tank]`; absent: it images the patient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tank: Option<RawTank>,
}

impl Default for RawProbe {
    fn default() -> Self {
        Self {
            width_mm: None,
            radius_mm: None,
            angle_deg: None,
            depth_mm: 60.0,
            pixel_mm: 0.2,
            rate_hz: 15.0,
            lag_ms: 0.0,
            speed_percent: 0.0,
            tank: None,
        }
    }
}

/// `[tracker.room.practice]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawPractice {
    /// Where the divot is that a tip is turned in, LPS mm.
    pub divot_ct_mm: [f64; 3],
    /// Where the calibration base stands.
    pub ct_from_base: RawRigid,
    /// How far off the point a touch is, standard deviation along each axis, mm.
    pub touch_error_mm: f64,
    /// How the tip trembles while it is held, standard deviation along each axis, mm.
    pub tremor_mm: f64,
}

impl Default for RawPractice {
    fn default() -> Self {
        Self {
            // Beside the patient, on the left.
            divot_ct_mm: [300.0, 0.0, 0.0],
            ct_from_base: RawRigid {
                quaternion: [1.0, 0.0, 0.0, 0.0],
                translation_mm: [300.0, 0.0, 100.0],
            },
            touch_error_mm: 0.3,
            tremor_mm: 0.05,
        }
    }
}

/// `[tracker.room.marker]`: a ball or a list of emitters, neither being the thesis's ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawMarker {
    /// Emitters even on a sphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball: Option<RawBall>,
    /// Emitters one by one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emitters: Option<Vec<RawEmitter>>,
    /// Half-angle of the cone in which an emitter shines, degrees; 180: everywhere.
    pub cone_deg: f64,
    /// Where the marker sits on the tool; absent: beside the end of the handle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marker_from_tool: Option<RawRigid>,
}

impl Default for RawMarker {
    fn default() -> Self {
        Self {
            ball: None,
            emitters: None,
            cone_deg: CONE_DEG,
            marker_from_tool: None,
        }
    }
}

/// An infrared diode shines about this far to each side.
const CONE_DEG: f64 = 60.0;

/// `ball = { emitters = 24, radius_mm = 50 }`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawBall {
    /// How many.
    pub emitters: u32,
    /// The sphere's, mm.
    pub radius_mm: f64,
}

impl Default for RawBall {
    fn default() -> Self {
        Self {
            emitters: 24,
            radius_mm: 50.0,
        }
    }
}

/// `{ at_mm = [x, y, z], normal = [x, y, z] }`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawEmitter {
    /// In the marker's frame, mm.
    pub at_mm: [f64; 3],
    /// Where it looks, of any length; absent: it is seen from everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
}

/// `[tracker.room.reference]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawReference {
    /// Emitters even on a sphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball: Option<RawBall>,
    /// Emitters one by one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emitters: Option<Vec<RawEmitter>>,
    /// Half-angle of the cone in which an emitter shines, degrees; 180: everywhere.
    pub cone_deg: f64,
    /// Where the marker sits on the patient.
    pub ct_from_reference: RawRigid,
}

impl Default for RawReference {
    fn default() -> Self {
        Self {
            ball: None,
            emitters: None,
            cone_deg: CONE_DEG,
            ct_from_reference: RawRigid {
                translation_mm: [150.0, -120.0, -150.0],
                ..RawRigid::default()
            },
        }
    }
}

/// `[tracker.room.handle]`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawHandle {
    /// From the tip back to its nearer end, mm; absent: the tube's length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_mm: Option<f64>,
    /// From the tip back to its farther end, mm; absent: 80 mm more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to_mm: Option<f64>,
    /// Its radius, mm; 0: it hides nothing.
    pub radius_mm: f64,
}

impl Default for RawHandle {
    fn default() -> Self {
        Self {
            from_mm: None,
            to_mm: None,
            radius_mm: 15.0,
        }
    }
}

/// `[tracker.room.hand]`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawHand {
    /// Its radius, mm.
    pub radius_mm: f64,
    /// From one coming to the next, s.
    pub every_s: f64,
    /// How long it stays, s.
    pub for_s: f64,
}

impl Default for RawHand {
    fn default() -> Self {
        Self {
            radius_mm: 45.0,
            every_s: 10.0,
            for_s: 1.5,
        }
    }
}

/// `[tracker.room.localizer]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawLocalizer {
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
    /// Coordinates are rounded to whole multiples of this, mm; 0: not at all.
    pub quantisation_mm: f64,
    /// Its eyes, in its own frame, mm.
    pub eyes_mm: Vec<[f64; 3]>,
    /// Half-angle of its field of view about its +z, degrees; 180: all directions.
    pub view_deg: f64,
    /// Emitters nearer than this are not seen, mm.
    pub nearest_mm: f64,
    /// Nor those farther away, mm.
    pub farthest_mm: f64,
    /// From the capture to the arrival, ms.
    pub latency_ms: f64,
    /// Added to it: uniform between 0 and this, ms.
    pub jitter_ms: f64,
    /// Chance that a frame never comes.
    pub dropped: f64,
    /// Chance that a frame comes late.
    pub late: f64,
    /// By how much, ms.
    pub late_ms: f64,
    /// How much faster than true time its clock goes, parts per million.
    pub drift_ppm: f64,
    /// What its clock says when the script starts, s.
    pub offset_s: f64,
}

impl Default for RawLocalizer {
    fn default() -> Self {
        Self {
            across_mm: 0.1,
            depth_mm: 0.15,
            at_mm: 2300.0,
            growth_across: 1.0,
            growth_depth: 2.0,
            quantisation_mm: 0.0,
            eyes_mm: vec![[0.0; 3]],
            view_deg: 180.0,
            nearest_mm: 0.0,
            farthest_mm: 100_000.0,
            latency_ms: 0.0,
            jitter_ms: 0.0,
            dropped: 0.0,
            late: 0.0,
            late_ms: 100.0,
            drift_ppm: 0.0,
            offset_s: 0.0,
        }
    }
}

/// `[tracker.room.patient]`
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawPatient {
    /// It slides, LPS mm a minute.
    pub drift_mm_per_min: [f64; 3],
    /// `[tracker.room.patient.breathing]`; absent: it holds its breath.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub breathing: Option<RawBreathing>,
    /// `[tracker.room.patient.bump]`; absent: nobody runs into it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bump: Option<RawBump>,
}

/// `[tracker.room.patient.breathing]`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawBreathing {
    /// From the end of the expiration to that of the inspiration, mm.
    pub amplitude_mm: f64,
    /// The way of the inspiration, LPS, of any length.
    pub direction: [f64; 3],
    /// One breath, s.
    pub period_s: f64,
}

impl Default for RawBreathing {
    fn default() -> Self {
        Self {
            amplitude_mm: 5.0,
            direction: [0.0, 0.0, -1.0],
            period_s: 4.0,
        }
    }
}

/// `[tracker.room.patient.bump]`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawBump {
    /// When it begins, s of the script.
    pub at_s: f64,
    /// How long it takes, s.
    pub over_s: f64,
    /// By how much the CT's origin moves, LPS mm.
    pub translation_mm: [f64; 3],
    /// The turn about the CT's origin, axis times angle, LPS degrees.
    pub rotation_deg: [f64; 3],
}

impl Default for RawBump {
    fn default() -> Self {
        Self {
            at_s: 10.0,
            over_s: 0.3,
            translation_mm: [0.0; 3],
            rotation_deg: [0.0; 3],
        }
    }
}

/// `[tracker.room.faults]`, of the tool's marker; emitters are counted from 0.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawFaults {
    /// Emitters that do not shine.
    pub dead: Vec<u32>,
    /// Two emitters whose names are exchanged; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swapped: Option<[u32; 2]>,
    /// Since when, s of the script.
    pub from_s: f64,
}

/// `[tracker.room.gates]` and `[tracker.room.reference_gates]`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawGates {
    /// Fewest emitters that a pose may rest on.
    pub min_emitters: u32,
    /// Largest root mean square residual of the emitters kept, mm.
    pub max_fre_mm: f64,
    /// An emitter whose residual is this many of its own deviations off is left out.
    pub outlier_sigmas: f64,
    /// Largest predicted error at the tip (at the target, for the patient's marker), 95 %, mm.
    pub max_tip_mm: f64,
}

impl Default for RawGates {
    fn default() -> Self {
        Self {
            min_emitters: 4,
            max_fre_mm: 1.0,
            outlier_sigmas: 5.0,
            max_tip_mm: 5.0,
        }
    }
}

/// `[tracker.room.gesture]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawGesture {
    /// A CSV file `t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm` of `ct_from_tool`; relative to the scene file.
    pub file: String,
    /// What comes after its last pose.
    #[serde(default)]
    pub at_end: AtEnd,
}

/// What comes after the last pose of a gesture from a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AtEnd {
    /// The tool stays there.
    #[default]
    Hold,
    /// The first one, again and again.
    Loop,
    /// Nothing: the localizer's frames end.
    Once,
}
