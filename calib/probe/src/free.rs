//! What a calibration leaves free, in words.

use std::fmt;

use nalgebra::{DMatrix, Matrix3, SMatrix, SVector, Vector3};

/// Of equations that give no image, the size of one: half of a usual one.
const RADIUS_MM: f64 = 25.0;

/// One motion of the image, with how far it may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    /// Root mean square way of the image's points in one deviation of this motion, mm.
    pub deviation_mm: f64,
    /// Turn in one deviation about the image's axes (along a row, along the beam, across the image), rad.
    pub turn: [f64; 3],
    /// Shift of the middle of the image along its axes, mm.
    pub shift_mm: [f64; 3],
    /// Change of both sizes of a pixel, as a share.
    pub sizes: [f64; 2],
    /// Way at the edge of the image that each of the eight makes, mm: what [`fmt::Display`] names the largest of.
    reach_mm: [f64; 8],
}

const NAMES: [&str; 8] = [
    "turns about its rows",
    "turns about the beam",
    "turns in its own plane",
    "slides along its rows",
    "slides along the beam",
    "slides across its plane",
    "is stretched along its rows",
    "is stretched along the beam",
];

/// The motions of a covariance about the middle of an image with these axes, the one that moves the image's points
/// most first.
pub(crate) fn of(about: &SMatrix<f64, 8, 8>, axes: &Matrix3<f64>, radius_mm: f64) -> Vec<Free> {
    let into = into_image(axes);
    let covariance = into * about * into.transpose();
    let eigen = covariance.symmetric_eigen();
    let root = eigen.eigenvectors * SMatrix::<f64, 8, 8>::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()));
    let modes = (root.transpose() * measure(radius_mm) * root).symmetric_eigen();
    let mut all: Vec<Free> = (0..8)
        .map(|k| one(&(root * modes.eigenvectors.column(k)), modes.eigenvalues[k], radius_mm))
        .collect();
    all.sort_by(|a, b| b.deviation_mm.total_cmp(&a.deviation_mm));
    all
}

/// Turn and shift in the image's own axes.
fn into_image(axes: &Matrix3<f64>) -> SMatrix<f64, 8, 8> {
    let mut into = SMatrix::<f64, 8, 8>::identity();
    into.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes.transpose());
    into.fixed_view_mut::<3, 3>(3, 3).copy_from(&axes.transpose());
    into
}

/// Mean square way of the points of an image of this radius: four points at its edge stand for all.
fn measure(radius_mm: f64) -> SMatrix<f64, 8, 8> {
    let at = radius_mm * std::f64::consts::FRAC_1_SQRT_2;
    let mut measure = SMatrix::<f64, 8, 8>::zeros();
    for (x, y) in [(at, at), (-at, at), (at, -at), (-at, -at)] {
        let mut way = SMatrix::<f64, 3, 8>::zeros();
        way.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&-Vector3::new(x, y, 0.0).cross_matrix());
        way.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        way[(0, 6)] = x;
        way[(1, 7)] = y;
        measure += way.transpose() * way / 4.0;
    }
    measure
}

fn one(motion: &SVector<f64, 8>, square: f64, radius_mm: f64) -> Free {
    let m = motion;
    Free {
        deviation_mm: square.max(0.0).sqrt(),
        turn: [m[0], m[1], m[2]],
        shift_mm: [m[3], m[4], m[5]],
        sizes: [m[6], m[7]],
        reach_mm: std::array::from_fn(|k| m[k].abs() * if (3..6).contains(&k) { 1.0 } else { radius_mm }),
    }
}

/// Of equations that cannot be solved: what they leave open.
pub(crate) fn open(normal: &DMatrix<f64>, axes: &Matrix3<f64>) -> String {
    let radius_mm = RADIUS_MM;
    let into = into_image(axes);
    let block = normal.fixed_view::<8, 8>(0, 0).into_owned();
    // In mm at the edge of the image, so that turns and shifts can be compared.
    let unit = SVector::<f64, 8>::from_fn(|k, _| if (3..6).contains(&k) { 1.0 } else { 1.0 / radius_mm });
    let scale = SMatrix::<f64, 8, 8>::from_diagonal(&unit);
    let eigen = (scale * into * block * into.transpose() * scale).symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let motion = scale * eigen.eigenvectors.column(least);
    words(&one(&motion, 0.0, radius_mm))
}

/// The largest parts of a motion.
fn words(free: &Free) -> String {
    let largest = free.reach_mm.iter().fold(0.0, |a: f64, b| a.max(*b));
    let parts = NAMES
        .iter()
        .zip(free.reach_mm)
        .filter(|(_, reach)| *reach > 0.4 * largest);
    let parts: Vec<&str> = parts.map(|(name, _)| *name).collect();
    format!("the image {}", parts.join(" and "))
}

impl fmt::Display for Free {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:.2} mm over the image", words(self), self.deviation_mm)
    }
}
