//! The drawing of a calibration base: TOML, lengths in mm, angles in degrees.

use std::path::{Path, PathBuf};

use calib::base::{Drawing, Groove, Refused};
use geometry::uncertain::CovarianceError;
use geometry::{Base, Point, Rigid, Tool, Uncertain, checked};
use nalgebra::{Matrix6, Vector6};
use serde::Deserialize;

use crate::commands::common::OwnError;
use crate::input_files::source::{Source, SourceError};

/// Why a drawing was not taken.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DrawingFileError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error("reading the drawing {path}: {source}")]
    Toml {
        path: PathBuf,
        source: Box<toml::de::Error>,
    },
    #[error("reading the drawing {path}: {count} tables [[groove]], the base has 3")]
    Grooves { path: PathBuf, count: usize },
    #[error("reading the drawing {path}: {key} is {found}, expected {expected}")]
    Value {
        path: PathBuf,
        key: &'static str,
        found: String,
        expected: &'static str,
    },
    #[error("the drawing {path}: {refused}. Draw three grooves of which not all run the same way")]
    Refused { path: PathBuf, refused: Box<Refused> },
    #[error("the drawing {path}: the deviations of the seat: {refused}")]
    Covariance {
        path: PathBuf,
        refused: Box<CovarianceError>,
    },
}

impl OwnError for DrawingFileError {}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDrawing {
    plane: RawPlane,
    groove: Vec<RawGroove>,
    seat: Option<RawSeat>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPlane {
    at_mm: [f64; 3],
    normal: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGroove {
    start_mm: [f64; 3],
    end_mm: [f64; 3],
    half_angle_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSeat {
    quaternion: [f64; 4],
    translation_mm: [f64; 3],
    #[serde(default)]
    sigma_mm: f64,
    #[serde(default)]
    sigma_deg: f64,
}

/// The base as drawn, and the seat of the tool in it.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub(crate) drawing: Drawing,
    pub(crate) base_from_tool: Option<Uncertain<Base, Tool>>,
}

impl Drawn {
    /// Reads a drawing.
    pub(crate) fn read(path: &Path) -> Result<Self, DrawingFileError> {
        Self::from_source(&Source::read_whole(path)?)
    }

    fn from_source(source: &Source) -> Result<Self, DrawingFileError> {
        let owned = || source.path.clone();
        let raw: RawDrawing = toml::from_str(&source.text).map_err(|error| DrawingFileError::Toml {
            path: owned(),
            source: Box::new(error),
        })?;
        let value = |key, found: String, expected| DrawingFileError::Value {
            path: owned(),
            key,
            found,
            expected,
        };
        let normal = checked::direction(raw.plane.normal).map_err(|_| {
            let found = format!("{:?}", raw.plane.normal);
            value("plane.normal", found, "three finite numbers, not all 0")
        })?;
        let count = raw.groove.len();
        let grooves: Result<[RawGroove; 3], _> = raw.groove.try_into();
        let grooves = grooves.map_err(|_| DrawingFileError::Grooves { path: owned(), count })?;
        let groove = |g: &RawGroove| Groove {
            start: point(g.start_mm),
            end: point(g.end_mm),
            half_angle_rad: g.half_angle_deg.to_radians(),
        };
        let [a, b, c] = &grooves;
        let drawing = Drawing::new(point(raw.plane.at_mm), normal, [groove(a), groove(b), groove(c)]);
        let drawing = drawing.map_err(|refused| DrawingFileError::Refused {
            path: owned(),
            refused: Box::new(refused),
        })?;
        let base_from_tool = raw.seat.as_ref().map(|s| seat(&source.path, s)).transpose()?;
        Ok(Self {
            drawing,
            base_from_tool,
        })
    }
}

fn point([x, y, z]: [f64; 3]) -> Point<Base> {
    Point::new(x, y, z)
}

/// The seat with its deviations, which are those of the tip and of a turn about it.
fn seat(path: &Path, raw: &RawSeat) -> Result<Uncertain<Base, Tool>, DrawingFileError> {
    let value = |key, found: String, expected| DrawingFileError::Value {
        path: path.to_owned(),
        key,
        found,
        expected,
    };
    let pose: Rigid<Base, Tool> = checked::rigid(raw.quaternion, raw.translation_mm, 1e-6).map_err(|_| {
        let found = format!("{:?} and {:?}", raw.quaternion, raw.translation_mm);
        value("seat", found, "a unit quaternion w, x, y, z and a finite translation")
    })?;
    for (key, x, most) in [
        ("seat.sigma_mm", raw.sigma_mm, 10.0),
        ("seat.sigma_deg", raw.sigma_deg, 10.0),
    ] {
        if !(0.0..=most).contains(&x) {
            return Err(value(key, x.to_string(), "a number from 0 to 10"));
        }
    }
    let (turn, shift) = (raw.sigma_deg.to_radians().powi(2), raw.sigma_mm.powi(2));
    let about = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift));
    let tip = Point::new(0.0, 0.0, 0.0) + pose.translation();
    Uncertain::from_covariance_about(tip, pose, about).map_err(|refused| DrawingFileError::Covariance {
        path: path.to_owned(),
        refused: Box::new(refused),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "\
[plane]
at_mm = [0, 0, 0]
normal = [0, 0, 2]

[[groove]]
start_mm = [15, 0, -4]
end_mm = [60, 0, -4]
half_angle_deg = 45

[[groove]]
start_mm = [-3, 15, -4]
end_mm = [-10, 60, -4]
half_angle_deg = 45

[[groove]]
start_mm = [-15, -15, -4]
end_mm = [-45, -45, -4]
half_angle_deg = 45

[seat]
quaternion = [1, 0, 0, 0]
translation_mm = [0, 0, 80]
sigma_mm = 0.05
";

    fn parse(text: &str) -> Result<Drawn, String> {
        let source = Source::from_bytes(Path::new("base.toml"), text.into()).map_err(|e| e.to_string())?;
        Drawn::from_source(&source).map_err(|e| e.to_string())
    }

    #[test]
    fn a_drawing_is_read() {
        let drawn = parse(GOOD).unwrap();
        let groove = drawn.drawing.grooves()[1];
        assert_eq!(groove.end.mm(), [-10.0, 60.0, -4.0]);
        assert!((groove.half_angle_rad - 45.0_f64.to_radians()).abs() < 1e-15);
        let tip = drawn.base_from_tool.unwrap() * Point::<Tool>::new(0.0, 0.0, 0.0);
        assert!((tip.covariance() - nalgebra::Matrix3::identity() * 0.0025).norm() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_told() {
        let with = |old: &str, new: &str| GOOD.replace(old, new);
        for (text, words) in [
            (
                with("normal = [0, 0, 2]", "normal = [0, 0, 0]"),
                "plane.normal is [0.0, 0.0, 0.0]",
            ),
            (with("[0, 0, 2]", "[0, 0, nan]"), "plane.normal"),
            (with("[seat]", "[sit]"), "unknown field `sit`"),
            (
                with("[[groove]]\nstart_mm = [15, 0, -4]", "[[groove]]\nstart_mm = [15, 0]"),
                "line 6",
            ),
            (
                GOOD.replace("half_angle_deg = 45", "half_angle_deg = 0"),
                "groove 0 is 45.000 mm long",
            ),
            (GOOD[..150].to_owned(), "TOML parse error at line"),
            (
                with("quaternion = [1, 0, 0, 0]", "quaternion = [1, 1, 0, 0]"),
                "seat is",
            ),
            (with("sigma_mm = 0.05", "sigma_mm = -1"), "seat.sigma_mm is -1"),
            (
                with(
                    "[seat]",
                    "[[groove]]\nstart_mm = [0, 0, 0]\nend_mm = [1, 0, 0]\nhalf_angle_deg = 45\n[seat]",
                ),
                "4 tables [[groove]]",
            ),
        ] {
            let error = parse(&text).unwrap_err();
            assert!(error.contains(words), "{words}: {error}");
        }
        let parallel = "[plane]\nat_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n".to_owned()
            + &(0..3)
                .map(|k| {
                    format!(
                        "[[groove]]\nstart_mm = [0, {}, 0]\nend_mm = [90, {}, 0]\nhalf_angle_deg = 45\n",
                        30 * k,
                        30 * k
                    )
                })
                .collect::<String>();
        let error = parse(&parallel).unwrap_err();
        assert!(error.contains("slide along (1.00, 0.00, 0.00)"), "{error}");
    }
}
