//! What a registration leaves free, in words: the motions along which the points hold it least.

use std::fmt;

use geometry::{Frame, Point};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

use crate::register::SurfaceRegistration;

/// One motion, with how far it may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    /// Root mean square, over the targets, of the way that they go in one deviation of this motion, mm.
    pub deviation_mm: f64,
    /// The turn of one deviation, rad, in the bone's frame.
    pub turn: [f64; 3],
    /// The way of the middle of the points in one deviation, mm.
    pub slide_mm: [f64; 3],
    /// A place of the axis of the turn, mm; `None` where it only slides.
    pub about_mm: Option<[f64; 3]>,
}

/// The motions of a registration in the order of what they do at the targets, the largest first: what of the pose is independent there.
///
/// Turns and shifts have no common unit; what is compared is the way that targets go, in mm. `Sigma` being the pose's covariance and `M`
/// the mean over the targets of `D'D`, `D` the way of a target in a motion, these are the eigenvectors of `S' M S`, `S S' = Sigma`.
pub fn free<To: Frame, From: Frame>(found: &SurfaceRegistration<To, From>, targets: &[Point<To>]) -> Vec<Free> {
    let centre = found.centre;
    let about: Matrix6<f64> = found.covariance_about_points().fixed_view::<6, 6>(0, 0).into_owned();
    let mut measure = Matrix6::zeros();
    for target in targets {
        let mut way = SMatrix::<f64, 3, 6>::zeros();
        let arm = Vector3::from(target.mm()) - centre;
        way.fixed_view_mut::<3, 3>(0, 0).copy_from(&-arm.cross_matrix());
        way.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        measure += way.transpose() * way / targets.len().max(1) as f64;
    }
    // A root of the covariance by its eigenvectors: it may be singular, where a number is held.
    let eigen = about.symmetric_eigen();
    let root = eigen.eigenvectors * Matrix6::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()));
    let modes = (root.transpose() * measure * root).symmetric_eigen();
    let mut all: Vec<Free> = (0..6)
        .map(|k| {
            let motion = root * modes.eigenvectors.column(k);
            let (w, v) = (
                motion.fixed_rows::<3>(0).into_owned(),
                motion.fixed_rows::<3>(3).into_owned(),
            );
            Free {
                deviation_mm: modes.eigenvalues[k].max(0.0).sqrt(),
                turn: w.into(),
                slide_mm: v.into(),
                about_mm: axis(&w, &v, found.radius_mm).map(|off| (centre + off).into()),
            }
        })
        .collect();
    all.sort_by(|a, b| b.deviation_mm.total_cmp(&a.deviation_mm));
    all
}

/// The place of a turn's axis nearest to the middle of the points, from there; `None` where the turn does less at the points than the
/// shift, so that the motion is a slide.
fn axis(w: &Vector3<f64>, v: &Vector3<f64>, radius_mm: f64) -> Option<Vector3<f64>> {
    // A point c of the axis is moved along it alone: v + w x c is parallel to w, and the nearest such c is w x v / w^2.
    let square = w.norm_squared();
    (w.norm() * radius_mm > v.norm() && square > 0.0).then(|| w.cross(v) / square)
}

impl fmt::Display for Free {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = |v: [f64; 3]| Vector3::from(v).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        match self.about_mm {
            Some([x, y, z]) => {
                let n = part(self.turn);
                let degrees = Vector3::from(self.turn).norm().to_degrees();
                write!(
                    f,
                    "turns about ({:.2}, {:.2}, {:.2}) through ({x:.0}, {y:.0}, {z:.0}) mm by {degrees:.1} degrees: {:.1} mm at the target",
                    n.x, n.y, n.z, self.deviation_mm
                )
            }
            None => {
                let n = part(self.slide_mm);
                write!(
                    f,
                    "slides along ({:.2}, {:.2}, {:.2}) by {:.1} mm: {:.1} mm at the target",
                    n.x,
                    n.y,
                    n.z,
                    Vector3::from(self.slide_mm).norm(),
                    self.deviation_mm
                )
            }
        }
    }
}
