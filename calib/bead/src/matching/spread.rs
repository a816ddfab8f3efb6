//! Whether points fix a rotation against their noise.

use geometry::Point;
use nalgebra::{Matrix3, Vector3};

use super::Refused;
use calib::registration::symmetric3;

/// Deviations of noise that the points must lie off their best line, root mean square.
const LEAST_WIDTH: f64 = 4.0;

/// Refuses points that noise of this deviation could have moved off a line.
pub(super) fn check<F>(points: &[Point<F>], sigma_mm: f64) -> Result<(), Refused> {
    let (width_mm, needed_mm) = (width_mm(points), LEAST_WIDTH * sigma_mm);
    if width_mm >= needed_mm {
        return Ok(());
    }
    Err(Refused::Collinear {
        points: points.len(),
        width_mm,
        needed_mm,
    })
}

/// Root mean square distance of points from the line that fits them best, mm.
pub(super) fn width_mm<F>(points: &[Point<F>]) -> f64 {
    let n = points.len() as f64;
    let centre = points.iter().map(|p| Vector3::from(p.mm())).sum::<Vector3<f64>>() / n;
    let outer = |p: &Point<F>| {
        let d = Vector3::from(p.mm()) - centre;
        d * d.transpose()
    };
    let (moments, _) = symmetric3(points.iter().map(outer).sum::<Matrix3<f64>>() / n);
    (moments.sum() - moments.max()).max(0.0).sqrt()
}
