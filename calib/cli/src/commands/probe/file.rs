//! `probe.json`: the image of a tracked ultrasound probe in its marker.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use calib::file::content_id;
use calib::gate::Verdict;
use geometry::{Image, Probe, Uncertain, checked};
use nalgebra::{Matrix6, SMatrix};
use probe::{CrossValidated, KnownImage, ProbeCalibration};
use serde::{Deserialize, Serialize};

use super::images::ImagesRecord;
use super::water::WaterRecord;
use crate::calibration::now;
use crate::input_files::source::Source;

/// The value of `format`.
pub const PROBE_FORMAT: &str = "trocar-probe";
/// The value of `version`. It rises when a key changes its meaning or goes; new keys leave it.
pub const PROBE_VERSION: u32 = 1;

/// The file's content. A pixel (u, v) lies at `R (u pixel_mm[0], v pixel_mm[1], 0) + t` in the probe's marker, mm;
/// whole numbers are
/// centres of pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeFile {
    /// [`PROBE_FORMAT`].
    pub format: String,
    /// [`PROBE_VERSION`].
    pub version: u32,
    /// Of the content: [`content_id`].
    pub id: String,
    /// The program that wrote it, and its version.
    pub program: String,
    /// When, RFC 3339 in UTC.
    pub date: String,
    /// `accepted` or `refused`.
    pub verdict: String,
    /// `wires` or `wall`.
    pub method: String,
    /// R as a unit quaternion w, x, y, z.
    pub quaternion_wxyz: [f64; 4],
    /// t, mm.
    pub translation_mm: [f64; 3],
    /// Size of a pixel along a row and along a column, mm.
    pub pixel_mm: [f64; 2],
    /// Covariance by rows of (w, v) in the marker about its origin, and of the logarithms of both sizes: rad, mm, 1, 1.
    /// The true image is `exp(w) (R p + t) + v`.
    pub covariance: Vec<Vec<f64>>,
    /// Least and largest column and row of the points: beyond them the errors grow.
    pub seen_px: [[f64; 2]; 2],
    /// Largest root mean square error by the covariance at the corners of `seen_px`, mm.
    pub error_mm: f64,
    /// The images that it holds for; files of before it was written have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub images: Option<ImagesRecord>,
    /// The water that it was calibrated in, where its temperature was told: then the image, `pixel_mm` among it, is that of tissue in
    /// which sound has the scanner's speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water: Option<WaterRecord>,
    /// The lag of the poses, where it was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag: Option<LagRecord>,
    /// How the phantom moved within its error, where that was not 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phantom: Option<MovedRecord>,
    /// Linear error of the tracker's shifts, by rows, where it was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker: Option<[[f64; 3]; 3]>,
    /// The place in the reference that this error is about, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker_about_mm: Option<[f64; 3]>,
    /// Frames that took part, and frames with points whose pose was lost.
    pub frames: [usize; 2],
    /// Points, and the share of them that was kept.
    pub points: usize,
    /// See `points`.
    pub share_kept: f64,
    /// Distances of the kept points from their wires or wall: mean and root mean square, mm.
    pub mean_mm: f64,
    /// See `mean_mm`.
    pub rms_mm: f64,
    /// Residuals in units of the noise told; where above 1, the covariance has grown with its square.
    pub noise_ratio: f64,
    /// By how much more neighbouring frames vary together than independent ones; the covariance has grown with it.
    pub frame_correlation: f64,
    /// Distances of frames that took no part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_validated: Option<CrossRecord>,
    /// The files it rests on.
    pub sources: Vec<ProbeSource>,
}

/// A lag: the pose that goes with an image of time t is that of t + lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LagRecord {
    /// s.
    pub lag_s: f64,
    /// Standard deviation, s.
    pub sigma_s: f64,
}

/// A motion of the phantom after its given place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MovedRecord {
    /// Rotation vector in the phantom's axes about its origin, rad.
    pub turn_rad: [f64; 3],
    /// mm.
    pub shift_mm: [f64; 3],
    /// Mean square in its given deviations.
    pub ratio: f64,
}

/// Mean distances of frames that took no part, mm, both ways.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CrossRecord {
    /// Every second frame judged by the others.
    pub every_second_mm: [f64; 2],
    /// The second half judged by the first, and the first by the second.
    pub halves_mm: [f64; 2],
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeSource {
    /// As given.
    pub path: String,
    /// BLAKE3 of its bytes; empty where it could not be read a second time.
    pub blake3: String,
}

/// Why a file was not taken.
#[derive(Debug, thiserror::Error)]
pub enum ProbeReadError {
    /// The file could not be read.
    #[error("{0}")]
    Source(String),
    /// The text is not such a file. Says line and column.
    #[error("reading the probe {path}: {source}")]
    Json {
        /// The file.
        path: PathBuf,
        /// What and where.
        source: serde_json::Error,
    },
    /// It says it is something else, was changed, was not accepted, or a number cannot be right.
    #[error("reading the probe {path}: {what}")]
    Bad {
        /// The file.
        path: PathBuf,
        /// What is found and what is expected.
        what: String,
    },
}

impl ProbeFile {
    pub(super) fn new(
        found: &ProbeCalibration,
        crossed: Option<&[CrossValidated; 2]>,
        (lost, images, water): (usize, ImagesRecord, Option<WaterRecord>),
        sources: Vec<&PathBuf>,
        verdict: &Verdict,
    ) -> Self {
        let image = found.probe_from_image.transform();
        let accepted = if verdict.is_accepted() { "accepted" } else { "refused" };
        let mut file = Self {
            format: PROBE_FORMAT.to_owned(),
            version: PROBE_VERSION,
            id: String::new(),
            program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
            date: now(),
            verdict: accepted.to_owned(),
            method: if found.wall.is_some() { "wall" } else { "wires" }.to_owned(),
            quaternion_wxyz: image.quaternion(),
            translation_mm: image.translation_mm(),
            pixel_mm: found.pixel_mm,
            covariance: (0..8)
                .map(|i| (0..8).map(|j| found.covariance[(i, j)]).collect())
                .collect(),
            seen_px: found.seen_px,
            error_mm: found.worst_mm(),
            images: Some(images),
            water,
            lag: found.lag.map(|lag| LagRecord {
                lag_s: lag.lag_s,
                sigma_s: lag.sigma_s,
            }),
            phantom: found.phantom.map(|moved| MovedRecord {
                turn_rad: moved.turn,
                shift_mm: moved.shift_mm,
                ratio: moved.ratio,
            }),
            tracker: found.tracker,
            tracker_about_mm: found.known().tracker.map(|(_, about)| about),
            frames: [found.frames, lost],
            points: found.points.len(),
            share_kept: found.share_kept,
            mean_mm: found.mean_mm,
            rms_mm: found.rms_mm,
            noise_ratio: found.noise_ratio,
            frame_correlation: found.frame_correlation,
            cross_validated: crossed.map(|[every, halves]| CrossRecord {
                every_second_mm: every.mean_mm,
                halves_mm: halves.mean_mm,
            }),
            sources: sources.into_iter().map(|path| source(path)).collect(),
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
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Reads a calibration and checks format, version, id, verdict and numbers.
    ///
    /// # Errors
    /// [`ProbeReadError`].
    pub fn read(path: &Path) -> Result<Self, ProbeReadError> {
        let source = Source::read_whole(path).map_err(|error| ProbeReadError::Source(error.to_string()))?;
        let file: Self = serde_json::from_str(&source.text).map_err(|source| ProbeReadError::Json {
            path: path.to_owned(),
            source,
        })?;
        match file.wrong() {
            None => Ok(file),
            Some(what) => Err(ProbeReadError::Bad {
                path: path.to_owned(),
                what,
            }),
        }
    }

    /// The image in the probe's marker, mm from its first pixel, with its covariance; `None` never of a file that
    /// was read.
    pub fn probe_from_image(&self) -> Option<Uncertain<Probe, Image>> {
        let rigid = checked::rigid(self.quaternion_wxyz, self.translation_mm, 1e-9).ok()?;
        let all = self.matrix()?;
        Uncertain::new(rigid, Matrix6::from_fn(|i, j| all[(i, j)])).ok()
    }

    /// What a check takes of it; `None` never of a file that was read.
    pub fn known(&self) -> Option<KnownImage> {
        Some(KnownImage {
            probe_from_image: self.probe_from_image()?.transform(),
            pixel_mm: self.pixel_mm,
            covariance: self.matrix()?,
            lag_s: self.lag.map_or(0.0, |lag| lag.lag_s),
            tracker: self.tracker.zip(self.tracker_about_mm),
        })
    }

    /// The covariance of all eight numbers.
    pub fn matrix(&self) -> Option<SMatrix<f64, 8, 8>> {
        let is_whole = self.covariance.len() == 8 && self.covariance.iter().all(|row| row.len() == 8);
        is_whole.then(|| SMatrix::from_fn(|i, j| self.covariance[i][j]))
    }

    fn wrong(&self) -> Option<String> {
        if (self.format.as_str(), self.version) != (PROBE_FORMAT, PROBE_VERSION) {
            let (format, version) = (self.format.chars().take(64).collect::<String>(), self.version);
            return Some(format!(
                "found format {format:?}, version {version}; expected {PROBE_FORMAT:?}, {PROBE_VERSION}"
            ));
        }
        let computed = self.content_id();
        if self.id != computed {
            let id: String = self.id.chars().take(64).collect();
            return Some(format!(
                "its id is {id:?} and its content has {computed}: it was changed; calibrate again"
            ));
        }
        if self.verdict != "accepted" {
            let verdict: String = self.verdict.chars().take(64).collect();
            return Some(format!("its verdict is {verdict:?}, only an accepted one is used"));
        }
        if !self.pixel_mm.iter().all(|size| (0.005..=2.0).contains(size)) {
            return Some(format!("pixel_mm is {:?}; 0.005 to 2 are allowed", self.pixel_mm));
        }
        let is_good = self.probe_from_image().is_some();
        (!is_good).then(|| "its transform is no rigid one, or its covariance is none".to_owned())
    }
}

fn source(path: &Path) -> ProbeSource {
    let mut hash = blake3::Hasher::new();
    let hashed = File::open(path).and_then(|mut file| io::copy(&mut file, &mut hash));
    ProbeSource {
        path: path.to_string_lossy().into_owned(),
        blake3: hashed.map_or(String::new(), |_| hash.finalize().to_hex().to_string()),
    }
}
