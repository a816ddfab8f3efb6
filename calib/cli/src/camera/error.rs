//! Why there is no camera, and what to do.

use std::path::PathBuf;

use optics::camera::CameraRefused;

use crate::input_files::source::SourceError;
use crate::store::StoreError;

/// Why there is no camera.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CameraError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Picture(#[from] picture::PngError),
    #[error("reading the grids in {path}: {source}. Write the file with calib grid --out")]
    Json { path: PathBuf, source: serde_json::Error },
    #[error("reading the grids in {path}: found trocar_grid {found}, expected 1. Write the file with calib grid --out")]
    Version { path: PathBuf, found: String },
    #[error("reading the grids in {path}: {image}: {what}. Write the file with calib grid --out")]
    BadGrid { path: PathBuf, image: String, what: String },
    #[error(
        "taking the views together: {first} has {} x {} pixels and {second} {} x {}. Give the images of one camera, all \
         of one size",
        .sizes[0][0], .sizes[0][1], .sizes[1][0], .sizes[1][1]
    )]
    Sizes {
        first: String,
        second: String,
        sizes: [[usize; 2]; 2],
    },
    #[error(
        "calibrating a lens: in {name} the grid was fitted as a whole, so that its discs lie on a homography and say \
         nothing of the lens. Run calib grid with --one-by-one, or give --lens pinhole"
    )]
    Whole { name: String },
    #[error("calibrating the camera from {views} views (counted from 0: {}): {refused}. {advice}", .names.join(", "))]
    Refused {
        views: usize,
        names: Vec<String>,
        refused: CameraRefused,
        advice: String,
    },
}

/// What a person can do about a refusal.
pub(super) fn advice(refused: &CameraRefused) -> &'static str {
    match refused {
        CameraRefused::TooFewViews { .. } => "Take more pictures, tilting the grid to all sides by about 30 degrees",
        CameraRefused::TooManyForField { .. } => "Give fewer pictures, of many tilts, or take --plate bent",
        CameraRefused::FieldUnsettled { .. } => "Take --plate bent, or more pictures",
        CameraRefused::Parallel { .. } => "Tilt the grid more: to the left and right, up and down, by about 30 degrees",
        CameraRefused::Identical { .. } => "Give each picture once",
        CameraRefused::Singular { .. } | CameraRefused::TooFewDiscs { .. } => {
            "Show more of the grid in that picture, or leave it out"
        }
        CameraRefused::NotFinite { .. }
        | CameraRefused::OffImage { .. }
        | CameraRefused::BadCovariance { .. }
        | CameraRefused::BadSize { .. } => "Write the file again with calib grid",
        CameraRefused::NoFreedom { .. } => "Take more pictures, or free fewer numbers with --lens",
        CameraRefused::Weak { .. } => {
            "Take pictures with the grid tilted more and larger, or free fewer numbers with --lens"
        }
        CameraRefused::Outliers { .. } => {
            "Look at the overlays of calib grid: are rows and columns right, and is --pitch-mm?"
        }
        CameraRefused::NotFlat { .. } => "Add --plate bent, or use a flat grid",
        CameraRefused::Folded { .. } | CameraRefused::NoConvergence { .. } => {
            "Free fewer numbers with --lens, and bring the grid to the image's corners"
        }
    }
}
