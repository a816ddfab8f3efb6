//! What is looked for and what is found.

use std::collections::HashSet;

use nalgebra::{Matrix2, Matrix3, Vector2};

use crate::disc::Ellipse;
use crate::grid::error::GridRefused;
use crate::image::Image;

/// The grid that is looked for.
#[derive(Debug, Clone, PartialEq)]
pub struct GridSpec {
    /// Discs in a row.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// Distance of neighbouring discs, mm.
    pub pitch_mm: f64,
    /// The discs are brighter than what surrounds them.
    pub bright: bool,
    /// Column and row, from 0, of its large discs. Where they are known they decide the grid's quarter turn, and which
    /// part of it a view shows that does not show all; without them a view must show every border line.
    pub marks: Vec<[usize; 2]>,
    /// Fit each disc by itself even where no distortion is seen: a calibration of the lens needs what a fit of the whole
    /// grid smooths away.
    pub one_by_one: bool,
}

impl GridSpec {
    /// Dark discs.
    pub fn new(cols: usize, rows: usize, pitch_mm: f64) -> Self {
        Self {
            cols,
            rows,
            pitch_mm,
            bright: false,
            marks: Vec::new(),
            one_by_one: false,
        }
    }

    pub(crate) fn check(&self, image: &Image) -> Result<(), GridRefused> {
        let Self {
            cols, rows, pitch_mm, ..
        } = *self;
        let outside = |m: &&[usize; 2]| m[0] >= cols || m[1] >= rows;
        if !(3..=200).contains(&cols) || !(3..=200).contains(&rows) {
            return Err(GridRefused::BadSize { cols, rows });
        }
        if !(pitch_mm.is_finite() && pitch_mm > 0.0) {
            return Err(GridRefused::BadPitch { pitch_mm });
        }
        if let Some([col, row]) = self.marks.iter().find(outside).copied() {
            return Err(GridRefused::BadMark { col, row, cols, rows });
        }
        // Two pixels a disc are the least that is ever resolved.
        // The shorter side of the grid along the shorter side of the image at the best.
        let (width, height, needed) = (image.width(), image.height(), 2 * cols.min(rows).max(4));
        if width.min(height) < needed {
            return Err(GridRefused::TooSmall {
                width,
                height,
                cols,
                rows,
                needed,
            });
        }
        Ok(())
    }
}

/// How centres were refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refinement {
    /// One fit of the whole grid as a plane: no lens distortion to be seen.
    Whole,
    /// One fit of the whole grid behind a lens of its own.
    Lens,
    /// Each disc by itself.
    Each,
}

/// The image of a disc that was fitted by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// As fitted; the disc's covariance is that of its centre, which perspective and the lens move off the image of the
    /// disc's centre.
    pub ellipse: Ellipse,
    /// The disc's radius beside the pitch, by the ellipse's area.
    pub radius: f64,
}

/// One disc of the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct GridDisc {
    /// Column, from 0.
    pub col: usize,
    /// Row, from 0.
    pub row: usize,
    /// The image of the disc's centre, pixels: not the centre of its image, which perspective moves.
    pub at: Vector2<f64>,
    /// Its covariance, pixels squared.
    pub covariance: Matrix2<f64>,
    /// A large disc.
    pub mark: bool,
    /// Its own fit; none where the grid was fitted as a whole.
    pub measured: Option<Measured>,
}

/// A grid in an image. Column 0, row 0 is the corner from which columns go to the right (to within 45 degrees for a
/// square grid) and rows down, unless large discs say otherwise; a grid without them looks the same after half a turn, a
/// square one after a quarter.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Discs that were seen, by rows.
    pub discs: Vec<GridDisc>,
    /// Column and row of those that were not.
    pub missing: Vec<[usize; 2]>,
    /// From (column, row) to pixels; with distortion the nearest homography.
    pub homography: Matrix3<f64>,
    /// A disc's radius beside the pitch.
    pub radius: f64,
    /// The blur's deviation with the pixel's area, pixels.
    pub sigma: f64,
    /// The residuals' deviation, grey levels.
    pub noise: f64,
    /// Root mean square distance of the discs from the homography, pixels: lens distortion. 0 for a plane.
    pub homography_rms_px: f64,
    /// What goes smoothly over the grid that the model of a fit of the whole leaves, beyond noise, root mean square over the
    /// discs, pixels: it is in the covariances. 0 where each disc was fitted by itself.
    pub misfit_px: f64,
    /// How the centres were refined.
    pub refinement: Refinement,
    /// Candidates there were.
    pub candidates: usize,
    /// In how many turns the object looks the same, so that the image cannot tell them apart: 1 where its large discs
    /// decide.
    pub alike: usize,
}

/// Places of the grid without a disc.
pub(crate) fn missing(discs: &[GridDisc], spec: &GridSpec) -> Vec<[usize; 2]> {
    let there: HashSet<[usize; 2]> = discs.iter().map(|d| [d.col, d.row]).collect();
    let all = (0..spec.rows).flat_map(|r| (0..spec.cols).map(move |c| [c, r]));
    all.filter(|cell| !there.contains(cell)).collect()
}
