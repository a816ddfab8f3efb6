//! A tool's frame in its marker, as `calib tool` writes it.

use geometry::{Marker, Point, Tool, Uncertain, checked};
use serde::Deserialize;

use super::{FileError, content_id, parsed, place, quoted, same};
use crate::gate::Reached;

/// The value of `trocar_calibration`.
const VERSION: u64 = 1;
const KIND: &str = "tool";
/// How far from 1 the norm of a quaternion may be that was written with all its digits.
const UNIT_TOLERANCE: f64 = 1e-9;

/// A calibrated tool, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolFile {
    /// The id of the file's content.
    pub id: String,
    /// When it was made, RFC 3339 in UTC.
    pub date_utc: String,
    /// Name of the instrument.
    pub tool: String,
    /// Name of the marker on it.
    pub marker: String,
    /// The tool's frame in its marker: origin at the tip, +z from the handle to the tip.
    pub marker_from_tool: Uncertain<Marker, Tool>,
    /// How good it is: of the error of the tip by the covariance, and of the pivoting or the seat that the tip is from, where it
    /// is.
    pub reached: Reached,
}

/// What is read of the file; its other keys are for people and for other programs.
#[derive(Deserialize)]
struct Raw {
    kind: String,
    id: String,
    date_utc: String,
    tool: String,
    marker: String,
    verdict: String,
    gates: Vec<RawGate>,
    tool_frame: Option<RawFrame>,
    #[serde(default)]
    pivot: Option<RawPivot>,
    #[serde(default)]
    seat: Option<RawSeat>,
}

/// Of a tool in its seat; files of before have neither residuals nor condition.
#[derive(Deserialize)]
struct RawSeat {
    frames: usize,
    #[serde(default)]
    rms_mm: Option<f64>,
    #[serde(default)]
    condition: Option<f64>,
}

#[derive(Deserialize)]
struct RawPivot {
    inliers: usize,
    rms_mm: f64,
    condition: f64,
    coverage: RawCoverage,
}

#[derive(Deserialize)]
struct RawCoverage {
    principal: Vec<RawPrincipal>,
}

#[derive(Deserialize)]
struct RawPrincipal {
    angle_deg: f64,
}

#[derive(Deserialize)]
struct RawGate {
    kept: bool,
}

#[derive(Deserialize)]
struct RawFrame {
    quaternion_wxyz: [f64; 4],
    translation_mm: [f64; 3],
    covariance_upper: [f64; 21],
}

impl ToolFile {
    /// Reads the text of such a file.
    ///
    /// # Errors
    /// Each variant of [`FileError`] but the last.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let value = parsed(text)?;
        let version = value.get("trocar_calibration");
        if version.and_then(serde_json::Value::as_u64) != Some(VERSION) {
            return Err(FileError::OtherVersion {
                found: version.map_or("no trocar_calibration".to_owned(), |v| {
                    quoted(&format!("trocar_calibration {v}"))
                }),
                expected: format!("trocar_calibration {VERSION}"),
            });
        }
        // From the text, so that errors tell line and column.
        let raw: Raw = serde_json::from_str(text)?;
        if raw.kind != KIND {
            let found = quoted(&raw.kind);
            return Err(FileError::OtherKind { found, expected: KIND });
        }
        // Before any number is believed: a file that was changed by hand is no calibration.
        let computed = content_id(value);
        if computed != raw.id {
            let found = quoted(&raw.id);
            return Err(FileError::OtherId { found, computed });
        }
        // The verdict and each gate: a file with one of them edited must not pass by the other.
        if raw.verdict != "accepted" || raw.gates.iter().any(|gate| !gate.kept) {
            return Err(FileError::NotAccepted(quoted(&raw.verdict)));
        }
        let marker_from_tool = frame(raw.tool_frame)?;
        Ok(Self {
            reached: reached(&marker_from_tool, raw.pivot.as_ref(), raw.seat.as_ref()),
            marker_from_tool,
            id: raw.id,
            date_utc: raw.date_utc,
            tool: raw.tool,
            marker: raw.marker,
        })
    }

    /// Refuses a calibration of another tool or marker than those in use.
    ///
    /// # Errors
    /// [`FileError::WrongPairing`].
    pub fn of(&self, tool: &str, marker: &str) -> Result<(), FileError> {
        same("tool", &self.tool, tool)?;
        same("marker", &self.marker, marker)
    }
}

fn reached(marker_from_tool: &Uncertain<Marker, Tool>, pivot: Option<&RawPivot>, seat: Option<&RawSeat>) -> Reached {
    let tip = *marker_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
    // The second angle is the cone's: see `coverage::Coverage::cone_rad`.
    let cone = |p: &RawPivot| p.coverage.principal.get(1).map(|axis| axis.angle_deg.to_radians());
    Reached {
        rms_mm: pivot.map(|p| p.rms_mm).or_else(|| seat?.rms_mm),
        tip_error_mm: Some(tip.rms_mm()),
        condition: pivot.map(|p| p.condition).or_else(|| seat?.condition),
        coverage_rad: pivot.and_then(cone),
        count: pivot.map(|p| p.inliers).or_else(|| Some(seat?.frames)),
        ..Reached::default()
    }
}

fn frame(raw: Option<RawFrame>) -> Result<Uncertain<Marker, Tool>, FileError> {
    let raw = raw.ok_or_else(|| FileError::number("tool_frame", &"nothing", "the tool's frame"))?;
    place("translation_mm", raw.translation_mm)?;
    let rigid = checked::rigid(raw.quaternion_wxyz, raw.translation_mm, UNIT_TOLERANCE)
        .map_err(|_| FileError::number("quaternion_wxyz", &raw.quaternion_wxyz, "a unit quaternion"))?;
    let uncertain = Uncertain::from_upper(rigid, raw.covariance_upper)
        .map_err(|error| FileError::number("covariance_upper", &error.to_string(), "a covariance"))?;
    // Zeros are a covariance, too, but no measurement is without error.
    let tip = (uncertain * Point::<Tool>::new(0.0, 0.0, 0.0)).covariance().trace();
    if tip > 0.0 {
        return Ok(uncertain);
    }
    Err(FileError::number(
        "covariance_upper",
        &tip,
        "a variance of the tip above 0 mm^2",
    ))
}
