//! Generated images held against closed forms that share nothing with their making.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod bone;
mod extremes;
mod patient;
mod speckle;
mod tank;

use ultrasound::{Beams, Body, Pose, Scanner, Scene, Settings, Shape};

/// Pixels are 0.1 mm, and the array is 40 mm wide, from column 0 on.
pub(crate) const PIXEL: f64 = 0.1;

/// 401 columns over 40 mm, 50 mm deep.
pub(crate) fn linear() -> Shape {
    let beams = Beams::Linear {
        from_mm: 0.0,
        to_mm: 40.0,
        face_mm: 0.0,
    };
    Shape::new([401, 501], [PIXEL; 2], beams, 50.0).unwrap()
}

/// The image's x and y are the patient's, its elevation is z; the middle of the face is at x = 20.
pub(crate) fn straight() -> Pose {
    Pose::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap()
}

/// Ramps as a CT's blur makes them, 1.6 mm wide, the middle of bone's ramp at distance 0 (negative inside).
pub(crate) fn bone_in(soft: f64, distance: f64) -> f64 {
    // Bone begins at 300 HU: the ramp is symmetric about it.
    let most = 600.0 - soft;
    soft + (most - soft) * (0.5 - distance / 1.6).clamp(0.0, 1.0)
}

pub(crate) fn image<B: Body>(shape: &Shape, settings: &Settings, body: &B, pose: &Pose) -> Vec<u8> {
    let mut scanner = Scanner::new(shape, settings).unwrap();
    scanner.scan(&Scene::of(body), pose, 7).unwrap()
}

/// The row of the brightest pixel of a column below `from`, and its grey.
pub(crate) fn brightest(shape: &Shape, grey: &[u8], column: usize, from: usize) -> (usize, u8) {
    let values = (from..shape.rows()).map(|row| (row, grey[row * shape.columns() + column]));
    // Of equal ones the middle: a saturated line is flat.
    let most = values.clone().map(|(_, grey)| grey).max().unwrap();
    let same: Vec<usize> = values.filter(|(_, grey)| *grey == most).map(|(row, _)| row).collect();
    (same[same.len() / 2], most)
}

/// The mean grey of a box of pixels.
pub(crate) fn mean(shape: &Shape, grey: &[u8], columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> f64 {
    let count = (columns.len() * rows.len()) as f64;
    let sum: f64 = rows
        .flat_map(|row| columns.clone().map(move |column| row * shape.columns() + column))
        .map(|at| f64::from(grey[at]))
        .sum();
    sum / count
}
