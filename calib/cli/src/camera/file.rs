//! `camera.toml`: a camera for people and programs.

use std::io;
use std::path::{Path, PathBuf};

use calib::camera::{Calibrated, Camera, NAMES, Options, PARAMETERS};
use calib::file::content_id;
use serde::{Deserialize, Serialize};

use super::read::Seen;
use crate::calibration::now;
use crate::source::Source;

/// The value of `format`.
pub const CAMERA_FORMAT: &str = "trocar-camera";
/// The value of `version`. It rises when a key changes its meaning or goes; new keys leave it.
pub const CAMERA_VERSION: u32 = 1;

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
    /// The order of `numbers`, `deviations` and `covariance`: fx, fy, cx, cy, skew in pixels, k1, k2, p1, p2, k3 without
    /// unit.
    pub names: Vec<String>,
    /// The camera.
    pub numbers: [f64; PARAMETERS],
    /// Their standard deviations, 0 where held.
    pub deviations: [f64; PARAMETERS],
    /// The lens' model holds to this tangent of the angle off the axis.
    pub domain_tangent: f64,
    /// Root mean square length of the residuals, pixels.
    pub rms_px: f64,
    /// The residuals in units of the deviations given; where above 1, the covariance has grown with its square.
    pub noise_ratio: f64,
    /// Discs that took part and that were left out.
    pub discs: [usize; 2],
    /// Largest difference of tilt between two views about the image's x and y axes, degrees.
    pub tilt_deg: [f64; 2],
    /// Share of the image's cells in which discs were seen.
    pub image_covered: f64,
    /// Covariance by rows.
    pub covariance: [[f64; PARAMETERS]; PARAMETERS],
    /// The files of grids.
    pub sources: Vec<SourceRecord>,
    /// The views.
    pub views: Vec<CameraView>,
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
            numbers: found.camera.numbers(),
            deviations: found.sigmas(),
            domain_tangent: found.camera.lens.limit(),
            rms_px: found.rms_px,
            noise_ratio: found.noise_ratio,
            discs: found.counts(),
            tilt_deg: found.coverage.tilt_rad.map(f64::to_degrees),
            image_covered: found.coverage.image,
            covariance: std::array::from_fn(|i| std::array::from_fn(|j| found.covariance[(i, j)])),
            sources: sources.iter().map(SourceRecord::of).collect(),
            views: views(found, seen),
        };
        file.id = file.content_id();
        file
    }

    fn content_id(&self) -> String {
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
        Camera::from_numbers(self.numbers)
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
        let names = self.names.iter().map(String::as_str).eq(NAMES);
        let good = self.numbers.iter().all(|x| x.is_finite()) && self.numbers[0] > 0.0 && self.numbers[1] > 0.0;
        (!names || !good).then(|| {
            format!(
                "{:?} must be {NAMES:?}, finite, the focal lengths above 0",
                self.numbers
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
    let one = |(posed, image): (&calib::camera::Posed, &super::read::SeenImage)| {
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
