//! Why there is no registration by the bone's surface.

use std::path::{Path, PathBuf};

use surface_registration::{FieldError, PointsError, RegisterError, SurfaceError};

use crate::calibration::CalibrationError;
use crate::commands::common::OwnError;
use crate::commands::probe::{ProbeCommandError, ProbeReadError};
use crate::foreign::ForeignError;
use crate::input_files::columns::TableError;
use crate::poses::{PixelsError, PosesError};
use crate::register::file::ReadError;
use crate::register::input_error::InputError;
use crate::text::shown;

/// No target of a patient lies further from his CT's origin along an axis, mm.
pub(super) const FAR_MM: f64 = 1e5;

/// Why there is no registration.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SurfaceCommandError {
    #[error(transparent)]
    Foreign(#[from] ForeignError),
    #[error("the bone {path}: {source}")]
    Surface { path: PathBuf, source: SurfaceError },
    #[error("the bone {path}: {source}")]
    Field { path: PathBuf, source: FieldError },
    #[error("reading what calib bone says of the bone, {path}: {what}")]
    Record { path: PathBuf, what: String },
    #[error(
        "{path} is of a surface whose bytes have the hash {told}, and {bone} has {found}: one of the two was changed; make the bone anew"
    )]
    OtherBone {
        path: PathBuf,
        bone: PathBuf,
        told: String,
        found: String,
    },
    #[error("the bone {path} is of the CT {found}, {expected} is used: take the bone of this CT")]
    OtherCt {
        path: PathBuf,
        found: String,
        expected: String,
    },
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("reading {path}: {what}")]
    Columns { path: PathBuf, what: &'static str },
    #[error("{path}: {source}{}", line_words(*line))]
    Points {
        path: PathBuf,
        /// The line of the point that is refused, where it is one.
        line: Option<usize>,
        source: PointsError,
    },
    #[error(transparent)]
    Probe(Box<ProbeReadError>),
    #[error(
        "image {seq} has pixels of {} x {} mm, the probe was calibrated with {} x {:.4} mm{cause}",
        found[0], found[1], expected[0], expected[1]
    )]
    OtherDepth {
        seq: u64,
        found: [f64; 2],
        expected: [f64; 2],
        /// Likely ones, in words.
        cause: String,
    },
    #[error(
        "image {seq} has another size, depth or array than the first of the sweep: leave the scanner as it is while you sweep"
    )]
    OtherShape { seq: u64 },
    #[error(
        "image {seq} has {what}: a picture that was cropped, moved or shown at another depth since, or another array, needs a calibration of its \
         own (calib probe)"
    )]
    OtherImages { seq: u64, what: String },
    #[error(
        "image {seq} is turned {found}, and the probe was calibrated with images turned {expected}: the picture was mirrored or turned on the \
         scanner since, or the scene says it wrongly (localizer.images.orientation)"
    )]
    OtherOrientation { seq: u64, found: String, expected: String },
    #[error(
        "{path} does not say {what}: it cannot be compared with what is used. Make it anew (calib probe, calib sweep), or say --unchecked-images \
         where you have seen that nothing was changed since"
    )]
    Unchecked { path: PathBuf, what: String },
    #[error(
        "the probe {path} is the calibration of the tool {expected:?}, and the run's tool is {found:?}{}: take that tool's calibration, or say \
         --probe-tool {expected} where both are one",
        alias_words(alias.as_deref())
    )]
    OtherTool {
        path: PathBuf,
        expected: String,
        found: String,
        alias: Option<String>,
    },
    #[error(
        "the points {points} were made with the probe's calibration {found:?}, and {path} is {expected:?}: take the calibration that they were \
         made with"
    )]
    OtherCalibration {
        points: PathBuf,
        found: String,
        path: PathBuf,
        expected: String,
    },
    #[error(
        "the points {points} were seen by a probe with the calibration {found:?}: say --probe with it; without it their errors are told too small"
    )]
    NeedsProbe { points: PathBuf, found: String },
    #[error("{0}")]
    AllRefused(String),
    #[error("{why}. Their {points} points are kept in {to}, and nothing is registered: sweep again")]
    MostRefused { to: PathBuf, points: usize, why: String },
    #[error("image {seq}: {why}")]
    NoShape { seq: u64, why: String },
    #[error(
        "image {seq} is stamped by its arrival: how late it is beside the poses is not one number, and no calibration of the lag holds for it"
    )]
    NotStamped { seq: u64 },
    #[error(
        "image {seq} and those after it came {by_ms:.0} ms later after their stamps than the first of the sweep did (20 at most): the clock of the \
         images was set, or does not go as that of the poses; one lag does not hold for both"
    )]
    OtherLateness { seq: u64, by_ms: f64 },
    #[error(
        "the probe {path} has no lag of its images behind the poses: find it (calib lag, or calib probe with --lag-ms) and say --lag-ms LAG,DEVIATION"
    )]
    NoLag { path: PathBuf },
    #[error("no sweep takes the images of this run's scene: {0}")]
    NoSweep(&'static str),
    #[error("in {seconds} s no image of an ultrasound probe came: does the run have one?")]
    NoImages { seconds: f64 },
    #[error(transparent)]
    Recorded(#[from] ProbeCommandError),
    #[error(transparent)]
    Pixels(#[from] PixelsError),
    #[error(transparent)]
    Poses(Box<PosesError>),
    #[error("{0} has no images: its header has no DimSize that is one's")]
    NoPixels(PathBuf),
    #[error(
        "none of {frames} frames of {path} has a valid pose {transform}: the marker was hidden, or --transform is another one's"
    )]
    NoTracked {
        path: PathBuf,
        frames: usize,
        transform: String,
    },
    #[error(
        "where beams run in the images is not known: say --array and --depth-mm, or --scan with a device set that has <ScanConversion>"
    )]
    NoBeams,
    #[error("the images of {path}: {what}")]
    NoImageShape { path: PathBuf, what: String },
    #[error("--lag-ms, or the lag of the calibration, needs times, and frame {frame} of {path} has none")]
    NoTimes { path: PathBuf, frame: u32 },
    #[error("--image-to-probe {given}: {what}")]
    Matrix { given: String, what: String },
    #[error("searching image {frame}: {source}")]
    Bone { frame: u32, source: echo::bone::BoneError },
    #[error("of {images} images of {path}, none shows bone where a pose is known. {reasons}")]
    NoBone {
        path: PathBuf,
        images: usize,
        reasons: String,
    },
    #[error("{of} has no covariance: the error that all points share cannot be told from it")]
    NoCovariance { of: String },
    #[error(
        "--tip needs the pose of the marker on the tool at each point: the columns marker_qw,marker_qx,marker_qy,marker_qz,marker_x,marker_y,marker_z of {path}; without \
         them say --shared-mm"
    )]
    NoMarkerPoses { path: PathBuf },
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Landmarks(#[from] InputError),
    #[error(transparent)]
    Guess(#[from] ReadError),
    #[error("the guess {path} is {found}, {expected} is needed")]
    OtherFrames {
        path: PathBuf,
        found: String,
        expected: String,
    },
    #[error("the guess {path}: its transform is none: {what}")]
    GuessNumbers { path: PathBuf, what: String },
    #[error("registering {path} to {bone}: {source}")]
    Register {
        path: PathBuf,
        bone: PathBuf,
        source: RegisterError,
    },
    #[error("{0}")]
    Volume(Box<dyn std::error::Error + Send + Sync>),
    #[error(
        "no target is given: --target x,y,z, or a scene with [[targets]]. Whether the error is small enough depends on where"
    )]
    NoTarget,
    #[error("a sweep is made in a run that is going: name it with --live")]
    NoRun,
    #[error(
        "the target {target:?} mm is no place in a patient: at most {} mm along each axis is allowed",
        FAR_MM
    )]
    FarTarget { target: [f64; 3] },
    #[error(
        "writing {path}: a result, one that is refused and the picture cannot be in one file; give each another name"
    )]
    Twice { path: PathBuf },
    #[error(
        "writing {path}: what lies beside a bone under its name says what it rests on (calib bone); give another --out"
    )]
    Beside { path: PathBuf },
    #[error("drawing {path}: {what}")]
    Picture { path: PathBuf, what: String },
}

impl OwnError for SurfaceCommandError {}

fn alias_words(alias: Option<&str>) -> String {
    alias.map_or_else(String::new, |alias| format!(" (--probe-tool {alias:?})"))
}

/// Indices of the numerics count points from 0; a person counts lines of the file.
fn line_words(line: Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(" (line {line} of the file)"))
}

impl SurfaceCommandError {
    /// Points that were refused, read from these lines.
    pub(super) fn points(path: &Path, lines: &[usize], source: PointsError) -> Self {
        let point = match source {
            PointsError::NotFinite { point, .. }
            | PointsError::Covariance { point }
            | PointsError::Depth { point, .. } => Some(point),
            _ => None,
        };
        Self::Points {
            path: path.to_owned(),
            line: point.and_then(|point| lines.get(point).copied()),
            source,
        }
    }

    pub(super) fn record(path: &Path, what: impl std::fmt::Display) -> Self {
        Self::Record {
            path: path.to_owned(),
            what: shown(&what.to_string()).chars().take(200).collect(),
        }
    }
}
