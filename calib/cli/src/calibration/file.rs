//! The file as a whole, and its identity.

use std::io;

use calib::file::content_id;
use serde::{Deserialize, Serialize};

use super::{
    BaseRecord, CALIBRATION_VERSION, Gate, ImportedRecord, MarkerRecord, PivotRecord, Recorded, SeatRecord, SpinRecord,
    ToolRecord, now,
};

/// What was calibrated; the key of the same name holds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The tip, by pivoting.
    Pivot,
    /// The axis of the shaft, by spinning.
    Spin,
    /// The tool's frame, from both or from its seat in the base.
    Tool,
    /// A marker's emitters.
    Marker,
    /// The place of the calibration base.
    Base,
}

impl Kind {
    /// The word in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pivot => "pivot",
            Self::Spin => "spin",
            Self::Tool => "tool",
            Self::Marker => "marker",
            Self::Base => "base",
        }
    }
}

/// The content of a calibration file. Numbers are written with the digits that bring back every bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrationFile {
    /// [`CALIBRATION_VERSION`].
    pub trocar_calibration: u32,
    /// What it is.
    pub kind: Kind,
    /// The first 16 hexadecimal digits of the BLAKE3 of everything else in the file: as JSON without blanks, keys in the
    /// order of the alphabet.
    pub id: String,
    /// When it was made, RFC 3339 in UTC.
    pub date_utc: String,
    /// The program that wrote it, and its version.
    pub program: String,
    /// Name of the instrument.
    pub tool: String,
    /// Name of the marker on it.
    pub marker: String,
    /// `accepted`: a result that fails a gate is not written.
    pub verdict: String,
    /// The bounds it kept.
    pub gates: Vec<Gate>,
    /// The recording it rests on.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub recorded: Option<Recorded>,
    /// Ids of the calibrations it rests on.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub computed_from: Vec<String>,
    /// Of kind `pivot`, and of kind `tool` where its tip is from pivoting.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pivot: Option<PivotRecord>,
    /// Of kind `spin`, and of kind `tool` where its axis is from spinning.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub spin: Option<SpinRecord>,
    /// Of kind `tool`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub tool_frame: Option<ToolRecord>,
    /// Of kind `tool` where another program calibrated it.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub imported: Option<ImportedRecord>,
    /// Of kind `tool` where it is from the seat in the base.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub seat: Option<SeatRecord>,
    /// Of kind `marker`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub marker_body: Option<MarkerRecord>,
    /// Of kind `base`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub base: Option<BaseRecord>,
}

impl CalibrationFile {
    /// A file of today without content.
    pub(crate) fn new(kind: Kind, tool: &str, marker: &str, gates: Vec<Gate>) -> Self {
        Self {
            trocar_calibration: CALIBRATION_VERSION,
            kind,
            id: String::new(),
            date_utc: now(),
            program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
            tool: tool.to_owned(),
            marker: marker.to_owned(),
            verdict: String::new(),
            gates: Vec::new(),
            recorded: None,
            computed_from: Vec::new(),
            pivot: None,
            spin: None,
            tool_frame: None,
            imported: None,
            seat: None,
            marker_body: None,
            base: None,
        }
        .with_gates(gates)
    }

    /// With these gates and the verdict that follows.
    pub(crate) fn with_gates(mut self, gates: Vec<Gate>) -> Self {
        let kept = gates.iter().all(|gate| gate.kept);
        self.verdict = if kept { "accepted" } else { "refused" }.to_owned();
        self.gates = gates;
        self
    }

    /// With the id of its content.
    ///
    /// # Errors
    /// None in practice, as [`Self::to_json`].
    pub fn sealed(mut self) -> io::Result<Self> {
        self.id = content_id(serde_json::to_value(&self)?);
        Ok(self)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// None in practice: the encoder has no number or name here that it could refuse.
    pub fn to_json(&self) -> io::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
