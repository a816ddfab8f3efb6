//! Why a run gave no poses and no touch.

use std::path::PathBuf;

use bus::BusError;
use bus::run::RunError;
use scene::SceneError;

use crate::input_files::source::SourceError;
use crate::store::StoreError;

/// Why a run gave nothing.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LiveError {
    #[error(transparent)]
    Folder(#[from] RunError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Bus(#[from] BusError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error("following the markers of run {run:?}: {why}")]
    Follow { run: String, why: String },
    #[error(
        "{of}: --{what} {given:?}, and its scene is of {what} {expected:?}; leave --{what} out, or take the scene of that \
         {what}"
    )]
    Other {
        of: String,
        what: &'static str,
        given: String,
        expected: String,
    },
    #[error("run {0:?} has no marker on the patient: --against reference has nothing to go by")]
    NoReference(String),
    #[error("given up; nothing is written")]
    Cancelled,
    #[error("run {run:?} ended after {seconds:.1} s of {asked} s; nothing is written")]
    Ended { run: String, seconds: f64, asked: f64 },
    #[error(
        "run {run:?}: no frame of emitters came in {seconds} s; is the localizer on? `pilot status --run {run}` says what \
         the tracker does"
    )]
    Silent { run: String, seconds: f64 },
    #[error("run {run:?}: none of {frames} frames in {seconds} s shows the marker; the last: {why}")]
    NotSeen {
        run: String,
        frames: usize,
        seconds: f64,
        why: String,
    },
    #[error(
        "touch of {name}: {poses} of {frames} frames show the marker, at least {needed} are needed; the last: {why}"
    )]
    Lost {
        name: String,
        poses: usize,
        frames: usize,
        needed: usize,
        why: String,
    },
    #[error(
        "touch of {name}: only {poses} poses in {seconds} s, at least {needed} are needed; hold still longer (--seconds)"
    )]
    TooFew {
        name: String,
        poses: usize,
        seconds: f64,
        needed: usize,
    },
    #[error(
        "touch of {name}: the tip moved by {moved_mm:.2} mm, {most_mm:.2} mm are allowed (--max-motion-mm); hold it still"
    )]
    Moved { name: String, moved_mm: f64, most_mm: f64 },
    #[error(
        "touch of {name}: the tip is not known: {why}. Calibrate it first (calib pivot), or name its file with --tip"
    )]
    NoTip { name: String, why: String },
    #[error(
        "{path}: its touches are in the {found}, and {given} is said; leave that out, or give the touches made in the {given}"
    )]
    OtherFrame {
        path: PathBuf,
        found: String,
        given: String,
    },
    #[error(
        "{path}: line {line} is {found:?}, expected once \"# places of the tip of TOOL in the FRAME, mm; calibration ID\", as calib touch writes \
         it: take the file as it was written"
    )]
    UnreadPlaces { path: PathBuf, line: usize, found: String },
    #[error("touch of {name}: {why}; hold it still, and calibrate the tip better (or for longer) before")]
    Gates { name: String, why: String },
    #[error("adding to {path}: {what}; give another --to")]
    OtherTouches { path: PathBuf, what: String },
    #[error("the covariance of a pose or of the tip: {0}")]
    Covariance(#[from] geometry::uncertain::CovarianceError),
}
