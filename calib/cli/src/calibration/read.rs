//! Reading a calibration back: nothing is taken on trust.

use std::path::{Path, PathBuf};

use calib::file::content_id;
use calib::pose::MAX_EMITTERS;
use geometry::checked;
use geometry::uncertain::Uncertain;
use geometry::{Marker, Rigid, Tool};
use serde_json::Value;

use super::{BaseRecord, CALIBRATION_VERSION, CalibrationFile, EmitterRecord, Kind, MarkerRecord};
use crate::input_files::fields::MAX_MM;
use crate::input_files::source::{Source, SourceError};

/// Why a calibration was not taken.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file could not be read.
    #[error("{0}")]
    Source(String),
    /// The text is not such a file.
    #[error("reading the calibration {path}: {source}")]
    Json {
        /// The file.
        path: PathBuf,
        /// What and where.
        source: serde_json::Error,
    },
    /// It says it is something else.
    #[error("reading the calibration {path}: found trocar_calibration {found}, expected {CALIBRATION_VERSION}")]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// The value found, or `nothing`.
        found: String,
    },
    /// It is of another kind than asked for.
    #[error("reading the calibration {path}: it is of kind {found}, {expected} is needed here")]
    OtherKind {
        /// The file.
        path: PathBuf,
        /// Its kind.
        found: &'static str,
        /// The kind asked for.
        expected: &'static str,
    },
    /// Its content is not what its id was made from.
    #[error(
        "reading the calibration {path}: its id is {found:?} and its content has {computed}: it was changed after it was \
         written; calibrate again"
    )]
    OtherId {
        /// The file.
        path: PathBuf,
        /// The id in the file.
        found: String,
        /// The id of the content.
        computed: String,
    },
    /// A number cannot be right.
    #[error("reading the calibration {path}: {what} is {found}, expected {expected}")]
    BadNumber {
        /// The file.
        path: PathBuf,
        /// The key.
        what: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// It was not accepted when it was made.
    #[error("reading the calibration {path}: its verdict is {verdict:?}, only an accepted one is used")]
    NotAccepted {
        /// The file.
        path: PathBuf,
        /// Its verdict.
        verdict: String,
    },
    /// It is of another marker or tool.
    #[error("the calibration {path} is of {what} {found:?}, the {user}'s is {expected:?}: take the file made for it")]
    WrongPairing {
        /// The file.
        path: PathBuf,
        /// `marker` or `tool`.
        what: &'static str,
        /// The name in the file.
        found: String,
        /// Whose name was expected, for instance `scene`.
        user: &'static str,
        /// The name expected.
        expected: String,
    },
}

impl From<SourceError> for CalibrationError {
    fn from(error: SourceError) -> Self {
        Self::Source(error.to_string())
    }
}

impl CalibrationFile {
    /// Reads a calibration of the kind asked for and checks version, kind, id, numbers and verdict.
    ///
    /// # Errors
    /// [`CalibrationError`].
    pub fn read(path: &Path, kind: Kind) -> Result<Self, CalibrationError> {
        let source = Source::read_whole(path)?;
        let path = path.to_owned();
        let failed = |source| CalibrationError::Json {
            path: path.clone(),
            source,
        };
        let value: Value = serde_json::from_str(&source.text).map_err(failed)?;
        let version = value.get("trocar_calibration").cloned();
        if version != Some(CALIBRATION_VERSION.into()) {
            let found = version.map_or("nothing".to_owned(), |v| v.to_string().chars().take(40).collect());
            return Err(CalibrationError::OtherVersion { path, found });
        }
        // From the text, so that errors tell line and column.
        let file: Self = serde_json::from_str(&source.text).map_err(failed)?;
        if file.kind != kind {
            let (found, expected) = (file.kind.name(), kind.name());
            return Err(CalibrationError::OtherKind { path, found, expected });
        }
        let computed = content_id(value);
        if computed != file.id {
            let found = file.id.chars().take(40).collect();
            return Err(CalibrationError::OtherId { path, found, computed });
        }
        file.checked(&path)
    }

    fn checked(self, path: &Path) -> Result<Self, CalibrationError> {
        let path = path.to_owned();
        if self.verdict != "accepted" || self.gates.iter().any(|gate| !gate.kept) {
            let verdict = self.verdict.chars().take(40).collect();
            return Err(CalibrationError::NotAccepted { path, verdict });
        }
        let bad = |(what, found, expected): (&'static str, String, &'static str)| {
            Err(CalibrationError::BadNumber {
                path,
                what,
                found,
                expected,
            })
        };
        self.first_bad().map_or(Ok(self), bad)
    }

    /// The first key whose numbers cannot be right, what it holds and what it should.
    fn first_bad(&self) -> Option<(&'static str, String, &'static str)> {
        let place = |what, v: &[f64; 3]| {
            let good = v.iter().all(|x| x.is_finite() && x.abs() <= MAX_MM);
            (!good).then(|| (what, format!("{v:?}"), "three numbers of at most 1e9 mm"))
        };
        let name = self.kind.name().to_owned();
        let no_part = || Some(("kind", name, "a part of the same name, and no other"));
        match (self.kind, &self.pivot, &self.spin, &self.tool_frame) {
            (Kind::Pivot, Some(pivot), None, None) => {
                let at = place("tip_mm", &pivot.tip_mm).or_else(|| place("pivot_mm", &pivot.pivot_mm));
                at.or_else(|| covariance("covariance_upper_mm2", pivot.covariance_upper_mm2.as_ref()))
            }
            (Kind::Spin, None, Some(spin), None) => {
                let length = spin.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
                let unit = (length - 1.0).abs() <= 1e-9;
                let axis = (!unit).then(|| ("axis", format!("{:?}", spin.axis), "a vector of length 1"));
                axis.or_else(|| place("point_mm", &spin.point_mm))
            }
            (Kind::Tool, _, _, Some(tool)) => {
                let unit = checked::rigid::<Marker, Tool>(tool.quaternion_wxyz, tool.translation_mm, 1e-9).is_ok();
                let q = || format!("{:?}", tool.quaternion_wxyz);
                let pose = (!unit).then(|| ("quaternion_wxyz", q(), "a unit quaternion and a finite translation"));
                pose.or_else(|| place("translation_mm", &tool.translation_mm))
                    .or_else(|| covariance("covariance_upper", Some(&tool.covariance_upper)))
            }
            (Kind::Marker, None, None, None) => self.marker_body.as_ref().map_or_else(no_part, first_bad_emitter),
            (Kind::Base, None, None, None) => self.base.as_ref().map_or_else(no_part, first_bad_place),
            _ => no_part(),
        }
    }

    /// Refuses a calibration of another marker; `user` is whose marker it is, for instance `scene`.
    ///
    /// # Errors
    /// [`CalibrationError::WrongPairing`].
    pub fn of_marker(&self, path: &Path, user: &'static str, expected: &str) -> Result<(), CalibrationError> {
        paired(path, "marker", &self.marker, user, expected)
    }

    /// Refuses a calibration of another tool.
    ///
    /// # Errors
    /// [`CalibrationError::WrongPairing`].
    pub fn of_tool(&self, path: &Path, user: &'static str, expected: &str) -> Result<(), CalibrationError> {
        paired(path, "tool", &self.tool, user, expected)
    }
}

fn paired(
    path: &Path,
    what: &'static str,
    found: &str,
    user: &'static str,
    expected: &str,
) -> Result<(), CalibrationError> {
    if found == expected {
        return Ok(());
    }
    Err(CalibrationError::WrongPairing {
        path: path.to_owned(),
        what,
        found: found.chars().take(40).collect(),
        user,
        expected: expected.to_owned(),
    })
}

/// The first bad number of a marker.
fn first_bad_emitter(marker: &MarkerRecord) -> Option<(&'static str, String, &'static str)> {
    let count = marker.emitters.len();
    if count > MAX_EMITTERS || marker.emitters.iter().flatten().count() < 3 {
        return Some((
            "emitters",
            format!("{count} of them"),
            "3 to 32, three of them with places",
        ));
    }
    let good = |e: &EmitterRecord| {
        let numbers = e.at_mm.iter().chain(e.normal.iter().flatten());
        numbers.copied().all(|x| x.is_finite() && x.abs() <= MAX_MM)
    };
    let bad = marker.emitters.iter().flatten().find(|e| !good(e))?;
    Some(("at_mm", format!("{:?}", bad.at_mm), "three numbers of at most 1e9 mm"))
}

/// The first bad number of a base.
fn first_bad_place(base: &BaseRecord) -> Option<(&'static str, String, &'static str)> {
    let unit = |q: [f64; 4], t: [f64; 3]| checked::rigid::<Marker, Tool>(q, t, 1e-9).is_ok();
    let pose = |q: [f64; 4], t: [f64; 3]| {
        let expected = "a unit quaternion and a finite translation";
        (!unit(q, t)).then(|| ("quaternion_wxyz", format!("{q:?}, {t:?}"), expected))
    };
    let seat = base.base_from_tool.as_ref();
    pose(base.quaternion_wxyz, base.translation_mm)
        .or_else(|| seat.and_then(|s| pose(s.quaternion_wxyz, s.translation_mm)))
        .or_else(|| covariance("covariance_upper", Some(&base.covariance_upper)))
        .or_else(|| covariance("base_from_tool.covariance_upper", seat.map(|s| &s.covariance_upper)))
}

/// Refuses what is no covariance; by the same door as that of transforms.
fn covariance(what: &'static str, upper: Option<&[f64; 21]>) -> Option<(&'static str, String, &'static str)> {
    let error = Uncertain::<Marker, Tool>::from_upper(Rigid::identity(), *upper?).err()?;
    Some((what, error.to_string(), "the upper triangle of a covariance"))
}
