//! Why there is no calibration.

use std::path::PathBuf;

use echo::GreyError;
use exchange::plus::PlusError;
use probe::{ProbeError, TrackError};

use super::file::ProbeReadError;
use crate::input_files::source::SourceError;
use crate::poses::{PixelsError, PosesError};
use crate::store::StoreError;

#[derive(Debug, thiserror::Error)]
pub(crate) enum ProbeCommandError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Poses(#[from] PosesError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Segment(#[from] SegmentError),
    #[error(transparent)]
    Pixels(#[from] PixelsError),
    #[error(
        "--water-celsius needs to know where beams run: say --array, or --scan with a device set that has <ScanConversion>"
    )]
    WaterArray,
    #[error("{path} has no <ScanConversion>: say --array and --depth-mm")]
    NoScan { path: PathBuf },
    #[error("reading {path}: {source}")]
    Plus { path: PathBuf, source: Box<PlusError> },
    #[error("{path}: {source}")]
    Wires { path: PathBuf, source: ProbeError },
    #[error("{path}: the covariance of the phantom's place: {source}")]
    Covariance {
        path: PathBuf,
        source: geometry::uncertain::CovarianceError,
    },
    #[error("reading {path}: {source}; expected {{\"frames\": {{\"0\": [{{\"wire\": \"name\", \"px\": [u, v]}}]}}}}")]
    Json { path: PathBuf, source: serde_json::Error },
    #[error("reading {path}: line {line}: found {found:?}, expected {expected}")]
    Csv {
        path: PathBuf,
        line: usize,
        found: String,
        expected: &'static str,
    },
    #[error("{path}: frame {found:?} is no number of a frame")]
    FrameName { path: PathBuf, found: String },
    #[error("{path}: frame {frame}: there is no wire {found:?}; there are {known}")]
    NoWire {
        path: PathBuf,
        frame: u32,
        found: String,
        known: String,
    },
    #[error("{path}: frame {frame} has points, and {sequence} has no frame of that number")]
    NoFrame {
        path: PathBuf,
        sequence: PathBuf,
        frame: u32,
    },
    #[error(
        "{lost} of {all} frames with points have no valid pose in {sequence}: more than half; the marker was hidden, or --transform is \
         another one's"
    )]
    Lost { sequence: PathBuf, lost: usize, all: usize },
    #[error("{path} has {found} points; at most {most} are read")]
    TooMany { path: PathBuf, found: usize, most: usize },
    #[error(transparent)]
    Read(#[from] Box<ProbeReadError>),
    #[error("--check: the file holds no image")]
    NoImage,
    #[error("poses over time: {0}")]
    Track(#[from] TrackError),
    #[error("calibrating the probe: {0}")]
    Probe(#[from] ProbeError),
}

/// Why images gave no points.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SegmentError {
    #[error(transparent)]
    Pixels(#[from] PixelsError),
    #[error("--region: {0}")]
    Region(#[from] GreyError),
    #[error("{path}: naming dots: {source}; give --points")]
    Drawing { path: String, source: echo::WiresError },
    #[error("{path}: of {images} images, none shows {what}. {reasons}")]
    Nothing {
        path: String,
        images: usize,
        what: &'static str,
        reasons: String,
    },
}
