//! A plan as it stands in a file: every key known, every type right.

use geometry::{Ct, Point};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::super::{Confirmed, Measure, Plan, Target};
use super::error::{FileError, quoted};
use super::{MAX_BYTES, PlanFile};
use crate::workflow::VolumeId;

const FORMAT: &str = "trocar-plan";
const VERSION: u64 = 1;
const FRAME: &str = "ct, LPS, mm";

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    format: String,
    version: u64,
    pub(super) id: String,
    written_by: String,
    made_at: String,
    changed_at: String,
    volume: RawVolume,
    frame: String,
    targets: Vec<RawTarget>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    measures: Vec<RawMeasure>,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    notes: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    confirmed: Option<RawConfirmed>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawVolume {
    hash: String,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTarget {
    name: String,
    ct_mm: [f64; 3],
    diameter_mm: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    entry_ct_mm: Option<[f64; 3]>,
    stop_mm: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMeasure {
    kind: RawKind,
    ct_mm: Vec<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawKind {
    Distance,
    Angle,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawConfirmed {
    by: String,
    at: String,
}

impl Raw {
    pub(super) fn parse(text: &str) -> Result<Self, FileError> {
        if text.len() > MAX_BYTES {
            return Err(FileError::TooLong { bytes: text.len() });
        }
        let value: Value = serde_json::from_str(text)?;
        let key = |key: &str| value.get(key).unwrap_or(&Value::Null);
        let (format, version) = (key("format"), key("version"));
        if format != FORMAT || version != VERSION {
            return Err(FileError::OtherVersion {
                found: quoted(&format!("{format}, version {version}")),
                is_newer: format == FORMAT && version.as_u64().is_some_and(|version| version > VERSION),
            });
        }
        // From the text, so that errors tell line and column.
        let raw: Self = serde_json::from_str(text)?;
        match raw.frame == FRAME {
            true => Ok(raw),
            false => Err(FileError::OtherFrame {
                found: quoted(&raw.frame),
            }),
        }
    }

    /// Of everything but the id. Keys stand in the order of the fields and numbers come back as they were written, so that blanks and
    /// the order in a file are of no meaning.
    pub(super) fn content_id(&self) -> String {
        let content = Self {
            id: String::new(),
            ..self.clone()
        };
        let mut hasher = blake3::Hasher::new_derive_key("trocar plan file 1");
        // Fails for no value of these types.
        hasher.update(&serde_json::to_vec(&content).unwrap_or_default());
        hasher.finalize().to_hex()[..16].to_owned()
    }

    pub(super) fn of(file: &PlanFile) -> Self {
        let plan = &file.plan;
        let raw = Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            id: String::new(),
            written_by: file.written_by.clone(),
            made_at: file.made_at.clone(),
            changed_at: file.changed_at.clone(),
            volume: RawVolume {
                hash: blake3::Hash::from_bytes(plan.volume.0).to_hex().to_string(),
            },
            frame: FRAME.to_owned(),
            targets: plan.targets.iter().map(RawTarget::of).collect(),
            measures: plan.measures.iter().map(RawMeasure::of).collect(),
            notes: plan.notes.clone(),
            confirmed: plan.confirmed.as_ref().map(|confirmed| RawConfirmed {
                by: confirmed.by.clone(),
                at: confirmed.at.clone(),
            }),
        };
        Self {
            id: raw.content_id(),
            ..raw
        }
    }

    pub(super) fn text(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }

    pub(super) fn into_file(self) -> Result<PlanFile, FileError> {
        let hash = blake3::Hash::from_hex(&self.volume.hash).map_err(|_| FileError::Hash {
            found: quoted(&self.volume.hash),
        })?;
        let measures = self.measures.into_iter().enumerate();
        let plan = Plan {
            volume: VolumeId(*hash.as_bytes()),
            targets: self.targets.into_iter().map(RawTarget::target).collect(),
            measures: measures.map(RawMeasure::measure).collect::<Result<_, _>>()?,
            notes: self.notes,
            confirmed: self.confirmed.map(|raw| Confirmed { by: raw.by, at: raw.at }),
        };
        Ok(PlanFile {
            plan: plan.checked()?,
            written_by: self.written_by,
            made_at: self.made_at,
            changed_at: self.changed_at,
        })
    }
}

impl RawTarget {
    fn of(target: &Target) -> Self {
        Self {
            name: target.name.clone(),
            ct_mm: target.centre.mm(),
            diameter_mm: target.diameter_mm,
            entry_ct_mm: target.entry.map(Point::mm),
            stop_mm: target.stop_mm,
        }
    }

    fn target(self) -> Target {
        Target {
            name: self.name,
            centre: point(self.ct_mm),
            diameter_mm: self.diameter_mm,
            entry: self.entry_ct_mm.map(point),
            stop_mm: self.stop_mm,
        }
    }
}

impl RawMeasure {
    fn of(measure: &Measure) -> Self {
        Self {
            kind: match measure {
                Measure::Distance(_) => RawKind::Distance,
                Measure::Angle(_) => RawKind::Angle,
            },
            ct_mm: measure.points().iter().map(|p| p.mm()).collect(),
        }
    }

    fn measure((place, raw): (usize, Self)) -> Result<Measure, FileError> {
        let points: Vec<Point<Ct>> = raw.ct_mm.into_iter().map(point).collect();
        let refused = |expected| FileError::Points {
            place,
            found: points.len(),
            expected,
        };
        match raw.kind {
            RawKind::Distance => points
                .as_slice()
                .try_into()
                .map(Measure::Distance)
                .map_err(|_| refused(2)),
            RawKind::Angle => points.as_slice().try_into().map(Measure::Angle).map_err(|_| refused(3)),
        }
    }
}

/// Checked with the whole plan.
fn point([x, y, z]: [f64; 3]) -> Point<Ct> {
    Point::new(x, y, z)
}
