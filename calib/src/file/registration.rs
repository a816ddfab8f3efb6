//! The patient's registration, as `calib register` writes it.

use geometry::{Ct, Frame, Point, Reference, Rigid, Tracker, Uncertain, checked};
use nalgebra::Matrix6;
use serde::Deserialize;
use serde_json::Value;

use super::{FileError, agrees, content_id, parsed, place, quoted, same};
use crate::gate::Reached;

const FORMAT: &str = "trocar-registration";
const VERSION: u64 = 1;
const UNIT_TOLERANCE: f64 = 1e-9;

/// Where the patient is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Registered {
    /// In the localizer, which must not move since: `from` is `tracker`.
    Fixed(Uncertain<Ct, Tracker>),
    /// In the marker on the patient: `from` is `reference`.
    Referenced(Uncertain<Ct, Reference>),
}

/// A registration of the patient, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct RegistrationFile {
    /// The id of the file's content, see [`content_id`].
    pub id: String,
    /// The transform with its covariance.
    pub registered: Registered,
    /// The hash of the CT volume that the points were taken from, where it was told.
    pub ct_hash: Option<String>,
    /// The marker that the points were seen by, where it was told.
    pub marker: Option<String>,
    /// Whether the covariance is too small: the file says that its touches do not tell what all share, the error of the tip's
    /// calibration, which more touches do not make less.
    pub lacks_shared: bool,
    /// Root mean square residual of the points, mm, and condition of their layout, where it was told.
    fre_rms_mm: Option<f64>,
    condition: Option<f64>,
}

/// What is read of the file.
#[derive(Deserialize)]
struct Raw {
    to: String,
    from: String,
    transform: RawTransform,
    covariance: Option<[[f64; 6]; 6]>,
    #[serde(default)]
    ct_hash: Option<String>,
    #[serde(default)]
    marker: Option<String>,
    #[serde(default)]
    fre_rms_mm: Option<f64>,
    #[serde(default)]
    condition: Option<f64>,
}

#[derive(Deserialize)]
struct RawTransform {
    quaternion_wxyz: [f64; 4],
    translation_mm: [f64; 3],
    scale: f64,
}

impl RegistrationFile {
    /// Reads the text of such a file.
    ///
    /// # Errors
    /// [`FileError::TooLong`], [`FileError::Json`], [`FileError::OtherVersion`], [`FileError::BadNumber`]: also where a
    /// scale was fitted, where there is no covariance, and between other frames than `ct` and `tracker` or `reference`.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let value = parsed(text)?;
        let key = |key: &str| value.get(key).unwrap_or(&Value::Null).clone();
        if key("format") != FORMAT || key("version") != VERSION {
            return Err(FileError::OtherVersion {
                found: quoted(&format!("format {}, version {}", key("format"), key("version"))),
                expected: format!("format {FORMAT:?}, version {VERSION}"),
            });
        }
        agrees(&value)?;
        let lacks_shared = lacks_shared(&value);
        // From the text, so that errors tell line and column.
        let raw: Raw = serde_json::from_str(text)?;
        Ok(Self {
            id: content_id(value),
            registered: raw.registered()?,
            ct_hash: raw.ct_hash,
            marker: raw.marker,
            lacks_shared,
            fre_rms_mm: raw.fre_rms_mm,
            condition: raw.condition,
        })
    }

    /// How good it is, for a point of the patient that counts; its error is predicted from the covariance.
    pub fn reached(&self, target: Point<Ct>) -> Reached {
        fn radius<From: Frame>(at: Uncertain<Ct, From>, target: Point<Ct>) -> f64 {
            (at * (at.transform().inverse() * target)).radius_95_mm()
        }
        Reached {
            rms_mm: self.fre_rms_mm,
            condition: self.condition,
            target_mm: Some(match self.registered {
                Registered::Fixed(ct_from_tracker) => radius(ct_from_tracker, target),
                Registered::Referenced(ct_from_reference) => radius(ct_from_reference, target),
            }),
            ..Reached::default()
        }
    }

    /// Refuses a registration made for another CT volume, or with another marker, than those in use. What the file does not
    /// tell is not checked.
    ///
    /// # Errors
    /// [`FileError::WrongPairing`].
    pub fn of(&self, ct_hash: &str, marker: &str) -> Result<(), FileError> {
        self.ct_hash
            .as_deref()
            .map_or(Ok(()), |found| same("CT", found, ct_hash))?;
        self.marker
            .as_deref()
            .map_or(Ok(()), |found| same("marker", found, marker))
    }
}

/// Whether the file says so: under `shared`, or, where it is of before that, under `noise.touches`.
fn lacks_shared(value: &Value) -> bool {
    let untold = |of: &str, key: &str| {
        let of = value.pointer(of).and_then(Value::as_object);
        of.is_some_and(|of| of.get(key).is_none_or(Value::is_null))
    };
    untold("/shared", "columns") || untold("/noise/touches", "shared_mm")
}

impl Raw {
    fn registered(&self) -> Result<Registered, FileError> {
        match (self.to.as_str(), self.from.as_str()) {
            ("ct", "tracker") => self.uncertain().map(Registered::Fixed),
            ("ct", "reference") => self.uncertain().map(Registered::Referenced),
            (to, from) => {
                let expected = "ct_from_tracker or ct_from_reference (calib register --to ct --from tracker)";
                Err(FileError::number("transform", &format!("{to}_from_{from}"), expected))
            }
        }
    }

    fn uncertain<From: Frame>(&self) -> Result<Uncertain<Ct, From>, FileError> {
        let t = &self.transform;
        // Exactly: `calib register` writes 1 where no scale was fitted.
        if t.scale != 1.0 {
            return Err(FileError::number("scale", &t.scale, "1: patients are measured in mm"));
        }
        place("translation_mm", t.translation_mm)?;
        let rigid: Rigid<Ct, From> = checked::rigid(t.quaternion_wxyz, t.translation_mm, UNIT_TOLERANCE)
            .map_err(|_| FileError::number("quaternion_wxyz", &t.quaternion_wxyz, "a unit quaternion"))?;
        let none = || FileError::number("covariance", &"null", "the covariance of three points or more");
        let rows = self.covariance.ok_or_else(none)?;
        let uncertain = Uncertain::new(rigid, Matrix6::from_fn(|i, j| rows[i][j]))
            .map_err(|error| FileError::number("covariance", &error.to_string(), "a covariance"))?;
        // The origin of the registered frame stands for the patient: its error is least near the points.
        let origin = (uncertain * Point::<From>::new(0.0, 0.0, 0.0)).covariance().trace();
        if origin > 0.0 {
            return Ok(uncertain);
        }
        Err(FileError::number("covariance", &origin, "a variance above 0 mm^2"))
    }
}
