//! `camera.toml`: a camera for people and programs.

use std::io;
use std::path::{Path, PathBuf};

use super::field::FieldRecord;
use calib::file::content_id;
use optics::camera::{Calibrated, Camera, NAMES, Options, PARAMETERS, Plate};
use serde::{Deserialize, Serialize};

use super::read::Seen;
use crate::calibration::now;
use crate::input_files::source::Source;

/// The value of `format`.
pub const CAMERA_FORMAT: &str = "trocar-camera";
/// The value of `version`. It rises when a key changes its meaning or goes; new keys leave it.
pub const CAMERA_VERSION: u32 = 1;
/// How many numbers files had before there were s1 to s4.
const BEFORE_THE_PRISM: usize = 10;

/// The file's content. Pixels have their centres at whole coordinates, x to the right, y down.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraFile {
    /// [`CAMERA_FORMAT`].
    pub format: String,
    /// [`CAMERA_VERSION`].
    pub version: u32,
    /// Of the content: [`content_id`].
    pub id: String,
    /// The program that wrote it, and its version.
    pub program: String,
    /// When, RFC 3339 in UTC.
    pub date: String,
    /// `accepted` or `refused`.
    pub verdict: String,
    /// What falls short, in words.
    pub reasons: Vec<String>,
    /// Columns and rows of pixels.
    pub image_px: [usize; 2],
    /// Which numbers were free: names of `names`.
    pub free: Vec<String>,
    /// The order of `numbers`, `deviations` and `covariance`: fx, fy, cx, cy, skew in pixels, k1, k2, p1, p2, k3, s1, s2,
    /// s3, s4 without unit. Files of programs before the prism end with k3.
    pub names: Vec<String>,
    /// The camera.
    pub numbers: Vec<f64>,
    /// Their standard deviations, 0 where held.
    pub deviations: Vec<f64>,
    /// The lens' model holds to this tangent of the angle off the axis.
    pub domain_tangent: f64,
    /// Root mean square length of the residuals, pixels.
    pub rms_px: f64,
    /// The residuals in units of the deviations given; where above 1, the covariance has grown with its square.
    pub noise_ratio: f64,
    /// By how much more than their noise single views have the camera elsewhere; files of programs before this have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view_ratio: Option<f64>,
    /// Discs that took part and that were left out.
    pub discs: [usize; 2],
    /// Largest difference of tilt between two views about the image's x and y axes, degrees.
    pub tilt_deg: [f64; 2],
    /// Share of the image's cells in which discs were seen.
    pub image_covered: f64,
    /// Covariance by rows.
    pub covariance: Vec<Vec<f64>>,
    /// How far the grid is from flat, where that was adjusted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plate: Option<PlateRecord>,
    /// The files of grids.
    pub sources: Vec<SourceRecord>,
    /// The views.
    pub views: Vec<CameraView>,
}

/// A grid's height over its plane, the same in all views: `b1 u^2 + b2 u w + b3 w^2`, mm, `(u, w)` the place on the grid
/// from `middle_mm` in units of `unit_mm`, along the grid's third axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlateRecord {
    /// b1, b2, b3, mm.
    pub bend_mm: [f64; 3],
    /// Their covariance by rows, square millimetres.
    pub covariance: [[f64; 3]; 3],
    /// The origin of (u, w) on the grid, mm.
    pub middle_mm: [f64; 2],
    /// Their unit, mm.
    pub unit_mm: f64,
    /// The field, where it was adjusted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<FieldRecord>,
}

impl PlateRecord {
    fn of(plate: &Plate) -> Self {
        let (middle, unit_mm) = plate.ruler_mm();
        Self {
            bend_mm: plate.numbers_mm(),
            covariance: std::array::from_fn(|i| std::array::from_fn(|j| plate.covariance[(i, j)])),
            middle_mm: middle.into(),
            unit_mm,
            field: None,
        }
    }
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceRecord {
    /// As given.
    pub path: String,
    /// BLAKE3 of its bytes.
    pub blake3: String,
    /// Its length.
    pub bytes: u64,
}

/// The grid in one image: `camera_from_grid`, the camera's frame with z forward, x to the right, y down, mm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraView {
    /// The image.
    pub image: String,
    /// Discs that took part and that were left out.
    pub discs: [usize; 2],
    /// Root mean square length of the residuals, pixels.
    pub rms_px: f64,
    /// Angle between the grid's normal and the camera's axis, degrees.
    pub tilt_deg: f64,
    /// The rotation: s, u1, u2, u3.
    pub quaternion: [f64; 4],
    /// The translation, mm.
    pub translation_mm: [f64; 3],
    /// Covariance of (rotation vector, translation) in the camera's frame, by rows, radians and mm.
    pub covariance: [[f64; 6]; 6],
}

/// Why a camera was not taken.
#[derive(Debug, thiserror::Error)]
pub enum CameraReadError {
    /// The file could not be read.
    #[error("{0}")]
    Source(String),
    /// The text is not such a file. Says line and column.
    #[error("reading the camera {path}: {source}")]
    Toml {
        /// The file.
        path: PathBuf,
        /// What and where.
        source: Box<toml::de::Error>,
    },
    /// It says it is something else, was changed, was not accepted, or a number cannot be right.
    #[error("reading the camera {path}: {what}")]
    Bad {
        /// The file.
        path: PathBuf,
        /// What is found and what is expected.
        what: String,
    },
}

impl CameraFile {
    pub(super) fn new(
        found: &Calibrated,
        seen: &Seen,
        options: &Options,
        sources: &[Source],
        reasons: &[String],
    ) -> Self {
        let accepted = if reasons.is_empty() { "accepted" } else { "refused" };
        let free = NAMES.iter().zip(options.free()).filter(|(_, free)| *free);
        let mut file = Self {
            format: CAMERA_FORMAT.to_owned(),
            version: CAMERA_VERSION,
            id: String::new(),
            program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
            date: now(),
            verdict: accepted.to_owned(),
            reasons: reasons.to_vec(),
            image_px: [seen.size.width, seen.size.height],
            free: free.map(|(name, _)| (*name).to_owned()).collect(),
            names: NAMES.map(str::to_owned).to_vec(),
            numbers: found.camera.numbers().to_vec(),
            deviations: found.sigmas().to_vec(),
            domain_tangent: found.camera.lens.limit(),
            rms_px: found.rms_px,
            noise_ratio: found.noise_ratio,
            view_ratio: Some(found.view_ratio).filter(|r| r.is_finite()),
            discs: found.counts(),
            tilt_deg: found.coverage.tilt_rad.map(f64::to_degrees),
            image_covered: found.coverage.image,
            covariance: (0..PARAMETERS)
                .map(|i| (0..PARAMETERS).map(|j| found.covariance[(i, j)]).collect())
                .collect(),
            plate: found.plate.as_ref().map(|plate| PlateRecord {
                field: FieldRecord::of(plate, seen),
                ..PlateRecord::of(plate)
            }),
            sources: sources.iter().map(SourceRecord::of).collect(),
            views: views(found, seen),
        };
        file.id = file.content_id();
        file
    }

    pub(super) fn content_id(&self) -> String {
        // Numbers, texts and lists of them: always a JSON value.
        content_id(serde_json::to_value(self).unwrap_or_default())
    }

    /// The file's text.
    pub(super) fn text(&self) -> io::Result<String> {
        toml::to_string(self).map_err(io::Error::other)
    }

    /// Reads a camera and checks format, version, id, verdict and numbers.
    ///
    /// # Errors
    /// [`CameraReadError`].
    pub fn read(path: &Path) -> Result<Self, CameraReadError> {
        let source = Source::read_whole(path).map_err(|error| CameraReadError::Source(error.to_string()))?;
        let file: Self = toml::from_str(&source.text).map_err(|source| CameraReadError::Toml {
            path: path.to_owned(),
            source: Box::new(source),
        })?;
        match file.wrong() {
            None => Ok(file),
            Some(what) => Err(CameraReadError::Bad {
                path: path.to_owned(),
                what,
            }),
        }
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        Camera::from_numbers(std::array::from_fn(|k| self.numbers.get(k).copied().unwrap_or(0.0)))
    }

    fn wrong(&self) -> Option<String> {
        let Self {
            format,
            version,
            id,
            verdict,
            ..
        } = self;
        if (format.as_str(), *version) != (CAMERA_FORMAT, CAMERA_VERSION) {
            let format: String = format.chars().take(64).collect();
            return Some(format!(
                "found format {format:?}, version {version}; expected {CAMERA_FORMAT:?}, {CAMERA_VERSION}"
            ));
        }
        let computed = self.content_id();
        if *id != computed {
            let id: String = id.chars().take(64).collect();
            return Some(format!(
                "its id is {id:?} and its content has {computed}: it was changed; calibrate again"
            ));
        }
        if verdict != "accepted" {
            return Some(format!(
                "its verdict is {:?}, only an accepted one is used",
                verdict.chars().take(64).collect::<String>()
            ));
        }
        let known = [NAMES.len(), BEFORE_THE_PRISM].contains(&self.names.len());
        let names = known && self.names.iter().zip(NAMES).all(|(a, b)| a == b);
        let whole = self.numbers.len() == self.names.len() && self.numbers.iter().all(|x| x.is_finite());
        let good = whole && self.numbers[..2].iter().all(|f| *f > 0.0);
        (!names || !good).then(|| {
            format!(
                "numbers {:?} must be {NAMES:?}, finite, the focal lengths above 0",
                self.numbers.iter().take(PARAMETERS).collect::<Vec<_>>()
            )
        })
    }
}

impl SourceRecord {
    fn of(source: &Source) -> Self {
        Self {
            path: source.path.to_string_lossy().into_owned(),
            blake3: source.blake3.clone(),
            bytes: source.bytes,
        }
    }
}

fn views(found: &Calibrated, seen: &Seen) -> Vec<CameraView> {
    let one = |(posed, image): (&optics::camera::Posed, &super::read::SeenImage)| {
        let used = posed.residuals.iter().filter(|r| r.used).count();
        CameraView {
            image: image.path.clone(),
            discs: [used, posed.residuals.len() - used],
            rms_px: posed.rms_px,
            tilt_deg: posed.tilt_rad.to_degrees(),
            quaternion: posed.pose.quaternion(),
            translation_mm: posed.pose.translation_mm(),
            covariance: std::array::from_fn(|i| std::array::from_fn(|j| posed.covariance[(i, j)])),
        }
    };
    found.views.iter().zip(&seen.images).map(one).collect()
}
