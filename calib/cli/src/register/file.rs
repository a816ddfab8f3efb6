//! `registration.json`: a registration that says what it is, what it rests on and how good it is.

use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::calibration::Gate;
use crate::input_files::source::{Source, SourceError};
use crate::register::surface::SurfaceRecord;

/// The value of `format`.
pub const FORMAT: &str = "trocar-registration";
/// The value of `version`. It rises when a key changes its meaning or goes; new keys leave it.
pub const VERSION: u32 = 1;

/// The file's content. Lengths in mm, angles in radians; numbers are written with the digits that bring back every bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RegistrationFile {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// The program that wrote it, and its version.
    pub program: String,
    /// The units of all numbers.
    pub units: Units,
    /// Name of the frame that is mapped into.
    pub to: String,
    /// Name of the frame that is mapped from.
    pub from: String,
    /// How the rotation was found, as on the command line.
    pub method: String,
    /// `to_from_from`.
    pub transform: Transform,
    /// Root of the weighted mean of the squared distances of the pairs used, mm: divides by N or the sum of weights. Of a registration by
    /// the bone's surface: of the distances of points to it.
    pub fre_rms_mm: f64,
    /// The longest distance of a pair or point used, mm.
    pub fre_max_mm: f64,
    /// `s1 / (s2 + s3)`: radians of rotation per relative error of the data's correlation. This and the next three: of pairs alone.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub condition: Option<f64>,
    /// Singular values of the correlation matrix of the centred clouds, relative to their sizes.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub singular_values: Option<[f64; 3]>,
    /// The proof that no other rotation fits better.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub certificate: Option<Certificate>,
    /// The noise that covariance and predicted TRE rest on.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub noise: Option<Noise>,
    /// Of (rotation vector, translation); `null` where the points do not determine one.
    pub covariance: Option<[[f64; 6]; 6]>,
    /// What the covariance means, in words.
    pub covariance_convention: String,
    /// Centre of the pairs used, or of all points of the surface, in `to`, mm.
    pub centre_mm: [f64; 3],
    /// Target registration error predicted at the centre and at each `--target`.
    pub predicted_tre: Vec<PredictedTre>,
    /// The tolerance of `--robust`, mm.
    pub robust_tolerance_mm: Option<f64>,
    /// What the error that all touches share, that of the tip's calibration, does to the transform. Files of before have none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub shared: Option<SharedPart>,
    /// The plane that the pairs lie in to their noise, as three always do. Files of before have none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub plane: Option<PlaneRecord>,
    /// Each pair in the order of the file.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub pairs: Vec<PairResult>,
    /// Of a registration by the bone's surface: what is known of it beside the pose.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub surface: Option<SurfaceRecord>,
    /// The files that were read.
    pub inputs: Vec<InputFile>,
    /// The bounds of a scene that it kept.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub gates: Vec<Gate>,
    /// The hash of the CT volume that `to` is of, where it was told; checked by [`RegistrationFile::paired`].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub ct_hash: Option<String>,
    /// The marker that the points were seen by, where it was told; checked likewise.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub marker: Option<String>,
}

/// A plane that the pairs lie in, to their noise: the pairs of a mirrored body fit as well, and put all that is off the plane on its other
/// side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlaneRecord {
    /// A point of it, the centre of the pairs, in `to`, mm.
    pub point_mm: [f64; 3],
    /// Its normal in `to`, of length 1.
    pub normal: [f64; 3],
    /// What that means, in words.
    pub side: String,
}

impl PlaneRecord {
    /// How far a point of `to` is off the plane, mm.
    pub fn off_mm(&self, point_mm: [f64; 3]) -> f64 {
        let along = |i: usize| (point_mm[i] - self.point_mm[i]) * self.normal[i];
        (along(0) + along(1) + along(2)).abs()
    }
}

/// The part of the registration's error that all its touches share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedPart {
    /// The tool's calibration, as the file of touches names it; `null` where it does not.
    pub calibration: Option<String>,
    /// What three normal numbers of deviation 1, those of `u1x` to `u3z` of touches, move (rotation vector, translation) by, in the
    /// convention of the covariance, which has it in it: a row for each of its six. `null` where the touches do not tell what they share:
    /// then **the covariance is too small**.
    pub columns: Option<[[f64; 3]; 6]>,
}

/// Units in words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Units {
    /// `mm`.
    pub length: String,
    /// `rad`.
    pub angle: String,
}

/// `p_to = scale * R * p_from + t`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// `TO_from_FROM`.
    pub name: String,
    /// What it does, in words.
    pub convention: String,
    /// Unit quaternion of R: w, x, y, z.
    pub quaternion_wxyz: [f64; 4],
    /// R as axis times angle, radians.
    pub rotation_vector_rad: [f64; 3],
    /// t, mm.
    pub translation_mm: [f64; 3],
    /// 1 unless `--scale` was given.
    pub scale: f64,
    /// Whether the scale was fitted.
    pub scale_fitted: bool,
    /// `scale * R` and t by rows, below them 0, 0, 0, 1.
    pub matrix: [[f64; 4]; 4],
}

/// See `calib::registration::Certificate`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// The rotation is the global optimum, to rounding.
    pub global_optimum: bool,
    /// How far from stationary, dimensionless; 0 at a stationary rotation.
    pub asymmetry: f64,
    /// Least eigenvalue of `tr(M) I - M`, dimensionless; not negative at the global optimum.
    pub least: f64,
    /// The largest angle to the optimum, radians; `null` where there is no bound.
    pub error_bound_rad: Option<f64>,
}

/// Noise of a pair of mean weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation along each axis, mm; root mean square of the pairs' where each has its own.
    pub sigma_mm: f64,
    /// From the residuals; else it was given.
    pub estimated: bool,
    /// Of residuals that it was estimated from: covariance and predicted TRE are for the variance that these suggest times
    /// `F_0.95(3, nu) / F_0.95(3, inf)`, as few residuals tell little of it. `null` where it was not estimated, and in files of before.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub degrees_of_freedom: Option<u32>,
    /// Where it was given and residuals show more: by what it was multiplied for their sake. `null` where they do not, and in files of before.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub times_told: Option<f64>,
    /// What it is made of where touches state their errors: covariance and predicted TRE then rest on those of each touch.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub touches: Option<TouchNoise>,
}

/// The parts of the error of touched points: standard deviations along an axis, root mean square of all pairs, mm. Their squares add
/// up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TouchNoise {
    /// As the file of touches states it, for each touch by itself: the noise of its poses.
    pub own_mm: f64,
    /// What all touches share, the error of the tip's calibration; `null` where the file does not tell it apart, and it is in
    /// `own_mm` as if it were each touch's own.
    pub shared_mm: Option<f64>,
    /// How far a hand is off the point: `--touch-mm`. Of `calib register` all that is left: the hand, and the point in `to`.
    pub hand_mm: f64,
    /// Of a bead's centre: `--bead-mm`; 0 of `calib register`.
    pub bead_mm: f64,
}

/// An error to be expected at a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PredictedTre {
    /// `centre` or `target`.
    pub at: String,
    /// In `to`, mm.
    pub point_mm: [f64; 3],
    /// Root mean square length, mm; `null` where the points do not determine it.
    pub rms_mm: Option<f64>,
}

/// A pair after registration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairResult {
    /// Lines of the `to` and of the `from` point in their files, counted from 1.
    pub lines: [usize; 2],
    /// Its label; empty without one.
    pub label: String,
    /// Weight in the fit, the largest 1; 0 for what was left out.
    pub weight: f64,
    /// Distance after registration, mm.
    pub fre_mm: f64,
    /// Distance under the transform fitted to all others, mm; `null` where these do not determine one.
    pub leave_one_out_mm: Option<f64>,
    /// With `--robust`: whether it agrees with the others; else `null`.
    pub inlier: Option<bool>,
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// `pairs`, or `to` and `from`.
    pub role: String,
    /// As given.
    pub path: String,
    /// Its length.
    pub bytes: u64,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

/// Why a registration could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file.
    #[error("{0}")]
    Source(String),
    /// The text is not such a file.
    #[error("reading the registration {path}: {source}")]
    Json {
        /// The file.
        path: PathBuf,
        /// What and where.
        source: serde_json::Error,
    },
    /// It says it is something else.
    #[error(
        "reading the registration {path}: found format {format:?}, version {version}; expected {FORMAT:?}, {VERSION}"
    )]
    OtherFormat {
        /// The file.
        path: PathBuf,
        /// Its `format`.
        format: String,
        /// Its `version`.
        version: u32,
    },
    /// It says the same in two ways that differ.
    #[error("reading the registration {path}: {source}: it was changed after it was written; register again")]
    Differs {
        /// The file.
        path: PathBuf,
        /// What differs.
        source: calib::file::FileError,
    },
    /// It does not say what it was made for.
    #[error(
        "the registration {path} does not say of which {what} it is, and {expected:?} is used: register again with --{option}, or ask \
         for none"
    )]
    Untold {
        /// The file.
        path: PathBuf,
        /// `CT` or `marker`.
        what: &'static str,
        /// The option that says it.
        option: &'static str,
        /// What it was to be used with.
        expected: String,
    },
    /// It is of another CT volume or marker.
    #[error(
        "the registration {path} is of {what} {found:?}, {expected:?} is used: register again, or take the file made for it"
    )]
    WrongPairing {
        /// The file.
        path: PathBuf,
        /// `the CT` or `marker`.
        what: &'static str,
        /// What the file was made for.
        found: String,
        /// What it was to be used with.
        expected: String,
    },
}

impl From<SourceError> for ReadError {
    fn from(error: SourceError) -> Self {
        Self::Source(error.to_string())
    }
}

impl RegistrationFile {
    /// The text of the file.
    ///
    /// # Errors
    /// None in practice: the encoder has no number or name here that it could refuse.
    pub fn to_json(&self) -> io::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Reads such a file; the numbers come back bit for bit.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let source = Source::read_whole(path)?;
        let file: Self = serde_json::from_str(&source.text).map_err(|source| ReadError::Json {
            path: path.to_owned(),
            source,
        })?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(ReadError::OtherFormat {
                path: path.to_owned(),
                format: file.format,
                version: file.version,
            });
        }
        let value = serde_json::from_str(&source.text).map_err(|source| ReadError::Json {
            path: path.to_owned(),
            source,
        })?;
        calib::file::agrees(&value).map_err(|source| ReadError::Differs {
            path: path.to_owned(),
            source,
        })?;
        Ok(file)
    }

    /// Refuses a registration that does not say the CT or the marker that a person names.
    ///
    /// # Errors
    /// [`ReadError::Untold`].
    pub fn tells(&self, path: &Path, ct_hash: Option<&str>, marker: Option<&str>) -> Result<(), ReadError> {
        let both = [
            ("CT", "ct-hash", &self.ct_hash, ct_hash),
            ("marker", "marker", &self.marker, marker),
        ];
        for (what, option, found, expected) in both {
            if let (None, Some(expected)) = (found, expected) {
                return Err(ReadError::Untold {
                    path: path.to_owned(),
                    what,
                    option,
                    expected: expected.to_owned(),
                });
            }
        }
        Ok(())
    }

    /// Refuses a registration made for another CT volume or another marker than those in use. What the file does not
    /// tell is not checked.
    ///
    /// # Errors
    /// [`ReadError::WrongPairing`].
    pub fn paired(&self, path: &Path, ct_hash: &str, marker: &str) -> Result<(), ReadError> {
        let both = [("the CT", &self.ct_hash, ct_hash), ("marker", &self.marker, marker)];
        for (what, found, expected) in both {
            if let Some(found) = found.as_deref().filter(|found| *found != expected) {
                return Err(ReadError::WrongPairing {
                    path: path.to_owned(),
                    what,
                    found: found.chars().take(80).collect(),
                    expected: expected.to_owned(),
                });
            }
        }
        Ok(())
    }
}
